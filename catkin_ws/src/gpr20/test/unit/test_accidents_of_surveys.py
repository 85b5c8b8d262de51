"""Accidents that no part of the robot is to blame for: disk, clock, plugs, people, programs."""

from __future__ import annotations

import contextlib
import errno
import time

import pytest
from failing_disk import FailingDisk, Failure
from robot_in_process import RobotInProcess
from stored_surveys import (
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
from gpr20_axis_driver.faults import AxisBusyError
from gpr20_main_control import faults
from gpr20_main_control.mid.survey import survey_archive
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import recover
from gpr20_survey.plan.survey_state import SurveyState

HOUR_S, DAY_S = 3600, 86_400


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


def test_a_clock_that_is_behind_the_traces_of_a_stopped_survey_is_said(robot, set_clock):
    robot.calls.at("sweep", 5, robot.control.stop)
    survey_id = robot.begin()
    check_state(robot, SurveyState.STOPPED)
    set_clock(-DAY_S)
    robot.go_on(survey=survey_id)
    check_said(robot, CLOCK_WRONG.as_warning())


# The antennas.


def test_a_plug_that_comes_loose_pauses_the_survey_at_its_first_stop(world):
    robot = RobotInProcess(world, reference_interval_s=10.0)
    robot.calls.at("sweep", 3, lambda: world.fault("LOOSE_PLUG"))
    robot.calls.at("sweep", 4, lambda: setattr(robot.clock, "more_s", robot.clock.more_s + 11.0))
    with contextlib.closing(robot):
        robot.begin()
        check_pause(robot, faults.DRIFTED.code, "drifted by 3.", "20.0 deg")
        robot.go_on()
        check_state(robot, SurveyState.FINISHED)
        assert [one["index"] for one in json_traces(robot)] == list(range(TRACES))
        records = recover(folder_of(robot)).found.records
        visits = [one.values for one in records if one.kind == Kind.DRIFT.value]
        flags = [(one["exceeded"], one["accepted"]) for one in visits]
        assert flags[:2] == [(True, False), (False, True)]
        assert all(abs(one["amplitude_rms_db"] - 3.1) < 0.2 for one in visits[-1]["rotations"])


# What people and other programs do.


def test_no_other_node_moves_an_axis_of_a_survey_or_sets_its_zero(robot):
    refused = []

    def ask():
        for axis, part in robot.axes.items():
            with pytest.raises(AxisBusyError, match="/main_control"), part.ownership.use("/other"):
                raise AssertionError(f"{axis} belongs to nobody")
            refused.append(axis)

    robot.calls.at("sweep", 3, ask)
    robot.begin()
    check_state(robot, SurveyState.FINISHED)
    assert refused == list(AxisId)
    assert len({tuple(one["zero_epochs"]) for one in check_complete(robot)}) == 1


def test_a_frozen_control_costs_a_move_but_no_coordinate(robot):
    def freeze():
        robot.calls.frozen_s += 3.0

    robot.calls.at("sweep", 2, lambda: robot.calls.at("step x", 300, freeze))
    # The carriage is on its way for long.
    robot.begin(x_stop_mm=230.0)
    check_state(robot, SurveyState.FINISHED)
    assert SurveyState.PAUSED not in [one.state for one in robot.history]
    assert len({tuple(one["zero_epochs"]) for one in check_complete(robot)}) == 1
