"""Homing: success, and every way in which it fails."""

import pytest
from axis_machine import SHORT, X_PARAMETERS, Axis
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_axis_driver.faults import EndstopError, MotionStopped
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.motion import never
from gpr20_survey.faults import ENDSTOP


@each_case("start_steps", [500, -99, -100, -150])
def test_homing_finds_the_same_zero_from_everywhere(start_steps):
    axis = Axis(SHORT, start_steps)
    axis.driver.homing(never)
    assert (axis.driver.homing_done, axis.driver.current_coord) == (True, 0.0)
    assert axis.machine.steps == 0


def test_the_endstop_is_touched_twice_at_the_lowest_speed():
    axis = Axis(X_PARAMETERS, start_steps=0)
    axis.driver.homing(never)
    turns = [direction for _time, direction in axis.machine.pulses]
    assert turns == [-1] * 100 + [1] * 100 + [-1] * 100 + [1] * 100
    assert min(axis.pauses_s) == pytest.approx(X_PARAMETERS.max_step)


def homing_steps_with_an_open_endstop(axis, *shown):
    """Home while the endstop never closes; return how many steps were made."""
    axis.machine.stuck = False
    before = len(axis.machine.pulses)
    with raises_fault(ENDSTOP, *shown, error=EndstopError):
        axis.driver.homing(never)
    assert not axis.driver.homing_done
    return len(axis.machine.pulses) - before


def test_an_axis_that_knows_where_it_is_does_not_push_far_beyond_its_endstop():
    axis = Axis(X_PARAMETERS)
    axis.driver.homing(never)
    axis.driver.move_to_coordinate(80.0, never)
    margin_mm = X_PARAMETERS.homing_backoff + X_PARAMETERS.homing_margin
    steps = homing_steps_with_an_open_endstop(axis, "91 mm")
    assert steps == X_PARAMETERS.distance_steps(80.0 + margin_mm)


def test_a_restarted_node_trusts_the_count_and_a_homing_that_failed_ends_that():
    axis = Axis(SHORT)
    axis.driver.homing(never)
    axis.driver = AxisDriver(SHORT, axis.pulses)
    assert homing_steps_with_an_open_endstop(axis, "11 mm") == 1100
    assert homing_steps_with_an_open_endstop(axis) == 2200


def test_a_homing_that_was_stopped_keeps_a_position_that_was_known():
    axis = Axis(SHORT)
    axis.driver.homing(never)
    axis.driver.move_to_coordinate(8.0, never)
    start = len(axis.machine.pulses)
    with pytest.raises(MotionStopped):
        axis.driver.homing(lambda: len(axis.machine.pulses) >= start + 300)
    assert homing_steps_with_an_open_endstop(axis, "16 mm") == 500 + 1100


def test_after_a_pressed_endstop_in_a_move_nothing_is_known():
    axis = Axis(SHORT)
    axis.driver.homing(never)
    axis.machine.stuck = True
    with raises_fault(ENDSTOP, error=EndstopError):
        axis.driver.move_to_coordinate(5.0, never)
    assert homing_steps_with_an_open_endstop(axis) == 2200


def test_a_motor_that_does_not_turn_is_not_taken_for_success():
    axis = Axis(X_PARAMETERS, start_steps=-100)
    axis.machine.lose_steps = True
    with raises_fault(ENDSTOP, error=EndstopError):
        axis.driver.homing(never)


def switches_elsewhere(machine):
    # The switch moves once the carriage has backed off from the first touch.
    if len(machine.pulses) == 700:
        machine.endstop_steps = -30


def stays_pressed(machine):
    machine.stuck = True if len(machine.pulses) > 620 else None


@each_case(
    "second_touch, fault",
    [(switches_elsewhere, ENDSTOP), (stays_pressed, ENDSTOP)],
)
def test_an_endstop_that_does_not_switch_at_the_same_place_again_is_an_error(second_touch, fault):
    axis = Axis(X_PARAMETERS)
    with raises_fault(fault, error=EndstopError):
        axis.driver.homing(lambda: bool(second_touch(axis.machine)))
    assert not axis.driver.homing_done
