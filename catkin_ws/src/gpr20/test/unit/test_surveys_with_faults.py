"""Faults of the simulated robot: what the operator reads, and that the survey continues.

A survey that meets a fault pauses; nothing wrong is stored; once the fault is gone it ends
with every point exactly once.
"""

from __future__ import annotations

import pytest
from simulated_world import STEP_MM
from stored_surveys import check_pause, check_resumed, check_state

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState

FAR_MM = 600.0


def test_an_endstop_that_closes_in_a_move_and_stays_closed_at_homing(world, robot):
    # The second row leads towards the endstop of x.
    robot.calls.at("sweep", 8, lambda: world.fault("STUCK_CLOSED", device="endstop_x"))
    robot.begin(x_stop_mm=FAR_MM)
    check_pause(robot, "axis.endstop")
    robot.go_on()
    check_pause(robot, "axis.endstop")
    world.fault("NONE", device="endstop_x")
    check_resumed(robot)
    # The axis has its zero back: it is where it reports to be.
    assert world.state.steps(AxisId.X) == round(FAR_MM / STEP_MM)


@pytest.mark.parametrize(
    "device, fault, code, values",
    [
        ("vna", "HANG", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "DROP", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "SILENT", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "LATE", "vna.no_answer", ["127.0.0.1"]),
        ("vna", "TRUNCATE", "vna.failed", []),
        ("vna", "NAN", "vna.failed", []),
        ("vna", "GARBAGE", "vna.wrong_instrument", ["MS2026C"]),
        ("vna", "STALE", "vna.failed", []),
        ("vna", "ENDLESS_DIGITS", "vna.failed", []),
        ("adc", "STUCK", "sensor.failed", []),
        ("adc", "OUT_OF_RANGE", "height.no_ground", ["0.1", "0.8"]),
    ],
    ids=str,
)
def test_a_fault_pauses_the_survey_and_once_it_is_gone_the_survey_ends_complete(
    world, robot, device, fault, code, values
):
    robot.calls.at("sweep", 4, lambda: world.fault(fault, device=device))
    robot.begin()
    check_pause(robot, code, *values)
    world.fault("NONE", device=device)
    check_resumed(robot)


def test_settings_that_are_refused_from_the_start_fail_the_survey_before_it_moves(world, robot):
    before = world.position()
    world.fault("REFUSE_SETTINGS")
    robot.begin()
    message = check_state(robot, SurveyState.FAILED).message
    assert message.fault_code == "vna.settings", message
    # It has 201 points since it was switched on.
    assert "201" in str(message) and "51" in str(message)
    assert world.position() == before
