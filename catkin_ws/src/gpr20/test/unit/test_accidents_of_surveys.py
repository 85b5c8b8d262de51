"""Accidents that no part of the robot is to blame for: disk, clock, plugs, people, programs."""

from __future__ import annotations

import errno
import time

import pytest
from failing_disk import FailingDisk, Failure
from robot_in_process import (
    TRACES,
    check_acknowledged,
    check_complete,
    check_pause,
    check_resumed,
    check_state,
    description_in,
    folder_of,
    json_traces,
)

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_main_control.mid.survey import survey_archive
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.plan.survey_state import SurveyState

HOUR_S = 3600


def check_verified(robot):
    found = verify_survey(folder_of(robot))
    assert (found.status, found.faults, found.unproven) == (COMPLETE, [], 0)
    check_acknowledged(robot, robot.world.acknowledged)


# The disk.


@pytest.fixture
def disk(world):
    world.data.mkdir(0o750)
    disk = FailingDisk(world.data)
    yield disk
    disk.release()


@pytest.mark.parametrize(
    "error, code, calls",
    [
        (errno.ENOSPC, "disk.full", 0),
        (errno.ENOSPC, "disk.full", 3),
        (errno.EROFS, "disk.refuses", 1),
        (errno.EIO, "disk.refuses", 3),
    ],
)
def test_a_disk_that_fails_pauses_the_survey_and_nothing_is_lost(
    tmp_path, disk, robot, monkeypatch, error, code, calls
):
    monkeypatch.setattr(survey_archive, "RETRY_S", 0.01)
    failure = Failure(calls, power=False, error=error)
    robot.calls.at("store", 5, lambda: disk.begin(failure, tmp_path / "unused"))
    robot.begin()
    check_pause(robot, code)
    acknowledged = {one.index for one in robot.world.acknowledged}
    assert acknowledged <= {one["index"] for one in json_traces(robot)}
    assert 4 <= len(acknowledged) < TRACES
    disk.end()
    check_resumed(robot)
    check_verified(robot)
    left = [one.name for one in folder_of(robot).rglob("*")]
    # A disk that cannot be written keeps what should be removed, too.
    hidden = [one for one in left if one.startswith(".") or one.endswith((".tmp", ".partial"))]
    assert not hidden or error != errno.ENOSPC


def test_a_survey_does_not_begin_where_it_cannot_be_stored(tmp_path, disk, world, robot):
    before = world.position()
    disk.begin(Failure(0, power=False, error=errno.EROFS), tmp_path / "unused")
    robot.begin()
    assert check_state(robot, SurveyState.FAILED).message.fault_code == "disk.refuses"
    disk.end()
    world.free_bytes = 1000
    robot.begin()
    assert check_state(robot, SurveyState.FAILED).message.fault_code == "disk.full"
    assert world.position() == before and not list(world.data.glob("*/traces/*"))


# The clock of the computer.


@pytest.fixture
def set_clock(monkeypatch):
    true_ns = time.time_ns

    def set_clock(offset_s):
        monkeypatch.setattr(time, "time_ns", lambda: true_ns() + offset_s * 10**9)

    return set_clock


def check_said(robot, fault):
    """Check that it is in the last status, in the report, and with at most one trace."""
    status = check_state(robot, SurveyState.FINISHED)
    assert status.full_message.fault_code == fault.code
    (warning,) = description_in(robot)["report"]["warnings"]
    assert warning["warning_message"]["code"] == fault.code
    stored = check_complete(robot)
    assert len([one for one in stored if "clock" in " ".join(one["quality"])]) <= 1
    assert all(one["sweep_started"] < one["sweep_ended"] for one in stored)
    check_verified(robot)


def test_a_clock_that_is_set_while_a_survey_is_paused_is_said_then(robot, set_clock):
    robot.calls.at("sweep", 5, lambda: robot.control.pause())
    robot.begin()
    check_state(robot, SurveyState.PAUSED)
    set_clock(-HOUR_S)
    robot.wait(lambda: robot.status.status.full_message.fault_code == CLOCK_WRONG.as_warning().code)
    robot.go_on()
    check_said(robot, CLOCK_WRONG.as_warning())
