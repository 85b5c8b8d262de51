"""The states of launches that have ended are cleared away; those that are in use never."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.low.stale_states import GRACE_S, remove_stale_states
from gpr20_survey.axes.axis_id import AxisId

STATE, OTHER = "0" * 32, "f" * 32
START = {axis: 0 for axis in AxisId}
OPEN_AND_WAIT = """
import sys, pathlib
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId
state = open_shared_state(pathlib.Path(sys.argv[1]), {axis: 0 for axis in AxisId})
print("open", flush=True)
sys.stdin.read()
"""


def grow_old(folder):
    for path in folder.iterdir():
        old_s = time.time() - 2 * GRACE_S
        os.utime(str(path), (old_s, old_s))


@pytest.fixture
def folder(tmp_path):
    """The states of two launches, with the step memories of their axes."""
    for name in (STATE, OTHER):
        for axis in AxisId:
            (tmp_path / f"{name}_{axis.value}_steps").write_bytes(b"steps")
    return tmp_path


def left(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_state_that_a_process_has_open_is_kept_until_that_process_is_killed(folder):
    command = [sys.executable, "-c", OPEN_AND_WAIT, str(folder / STATE)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as owner:
        assert owner.stdout.readline() == b"open\n"
        grow_old(folder)
        assert remove_stale_states(folder) == 3
        assert [name for name in left(folder) if not name.startswith(STATE)] == []
        assert len(left(folder)) == 4
        owner.kill()
        owner.wait()
    assert remove_stale_states(folder) == 4
    assert left(folder) == []


def test_a_state_that_was_just_made_is_kept(folder):
    assert remove_stale_states(folder) == 0
    assert len(left(folder)) == 6


def test_what_is_no_state_is_left_alone(folder):
    (folder / "notes.txt").write_text("somebody else's")
    (folder / f"{STATE}.txt").write_text("somebody else's")
    grow_old(folder)
    assert remove_stale_states(folder) == 6
    assert left(folder) == [f"{STATE}.txt", "notes.txt"]


def test_there_may_be_no_states_at_all(tmp_path):
    assert remove_stale_states(tmp_path / "missing") == 0


def test_a_state_that_was_cleared_away_is_made_anew(tmp_path):
    open_shared_state(tmp_path / STATE, START)
    (tmp_path / STATE).unlink()
    open_shared_state(tmp_path / STATE, START)
    assert (tmp_path / STATE).is_file()
