"""Surveys of two machines over a link that loses packets, and that fails for a while.

The seed of the moment at which it fails is in the name of the test. Environment variables make it
harder: GPR20_LINK_SEEDS (how many seeds), GPR20_LINK_POINTS (points of a row), GPR20_LINK_LOSS (of
a hundred packets in each direction), GPR20_LINK_CUT_S (longer than a client waits: 35 s of silence,
which it notices after 5 s).
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter

import pytest
from network_namespaces import (
    CLIENT,
    launched,
    outcome,
    statuses,
    stored_traces,
    survey_folder,
    two_machines,
)
from user_shell import has_bag
from wait_kit import wait_until

SEEDS = int(os.environ.get("GPR20_LINK_SEEDS", "1"))
POINTS = int(os.environ.get("GPR20_LINK_POINTS", "3"))
CUT_S = float(os.environ.get("GPR20_LINK_CUT_S", "45"))
LOSS = int(os.environ.get("GPR20_LINK_LOSS", "5"))
TRACES = 3 * POINTS * 2
CONTACT_LOST, STOPPED_BY_CTRL_C = 3, 130
SURVEY = f"{CLIENT} --x-points {POINTS} --y-points 3"

pytestmark = [pytest.mark.release, pytest.mark.needs("network namespaces", "firewall")]


def lose(machines, percent):
    for one in machines:
        one.lose(percent)


def check_complete(folder):
    assert outcome(folder) == "finished"
    assert stored_traces(folder) == Counter(range(TRACES))
    wait_until(lambda: has_bag(survey_folder(folder)))
    verify = [sys.executable, "-m", "gpr20_analysis.commands.main", "verify"]
    subprocess.run([*verify, survey_folder(folder)], check=True)


def check_stop(on_robot, folder):
    """Stop a survey by Ctrl-C at its client."""
    client = on_robot.start(SURVEY)
    wait_until(lambda: statuses(folder)[-1][0] == "SURVEYING", alive=[client])
    client.send_signal(signal.SIGINT)
    assert client.wait(60.0) == STOPPED_BY_CTRL_C
    assert statuses(folder)[-1][0] == "STOPPED"


@pytest.mark.parametrize("seed", range(1, 1 + SEEDS))
def test_a_survey_over_a_bad_link_continues_by_itself_when_the_link_was_down(tmp_path, seed):
    draw = random.Random(seed)
    with two_machines() as machines, launched(*machines, tmp_path) as (_on_server, on_robot):
        lose(machines, LOSS)
        client = on_robot.start(SURVEY)
        cut_at = draw.randrange(2, TRACES - 2)
        wait_until(lambda: sum(stored_traces(tmp_path).values()) >= cut_at, alive=[client])
        before_cut = len(statuses(tmp_path))
        # At rest, nodes that are still starting are named.
        states = [state for state, _message in statuses(tmp_path) if state != "IDLE"]
        # Late answers are no lost nodes: a state may say what it waits for, but it stays.
        changes = [new for old, new in zip(["IDLE", *states], states) if new != old]
        assert changes == ["CONFIGURED", "CHECKING", "HOMING", "SURVEYING"], states
        time.sleep(draw.uniform(0.0, 2.0))
        lose(machines, 100)
        time.sleep(CUT_S)
        lose(machines, LOSS)
        # The client has given up; the survey has not.
        assert client.wait(60.0) == CONTACT_LOST
        wait_until(lambda: statuses(tmp_path)[-1][0] == "FINISHED")
        states = [state for state, _message in statuses(tmp_path)[before_cut:]]
        # The survey has waited once, and nobody has resumed it.
        changes = [new for old, new in zip(["SURVEYING", *states], states) if new != old]
        assert changes == ["CHECKING", "HOMING", "SURVEYING", "FINISHED"], states
        check_complete(tmp_path)
        check_stop(on_robot, tmp_path)
