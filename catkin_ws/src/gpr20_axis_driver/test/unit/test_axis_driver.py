"""Moves of one axis: where they end and what ends them."""

import contextlib
import math
import random

import pytest
from axis_machine import X_PARAMETERS, Axis
from case_kit import each_case
from fault_kit import raises_fault
from run_seed import draws

from gpr20_axis_driver.faults import (
    AxisBusyError,
    EndstopError,
    MotionStopped,
    NotHomedError,
    TravelError,
)
from gpr20_axis_driver.motion import never
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_survey.faults import ENDSTOP


@pytest.fixture
def axis():
    axis = Axis(X_PARAMETERS)
    axis.driver.homing(never)
    axis.machine.pulses.clear()
    return axis


def stop_after(pulses, machine):
    return lambda: len(machine.pulses) >= pulses


@each_case("target", [-0.01, 650.01, math.nan, math.inf, -math.inf])
def test_a_target_outside_the_axis_is_refused_and_moves_nothing(axis, target):
    with raises_fault(NOT_ALLOWED, 0, 650, "mm", error=TravelError):
        axis.driver.move_to_coordinate(target, never)
    assert axis.machine.pulses == []


def test_a_stopped_move_slows_down_and_keeps_an_exact_coordinate(axis):
    with raises_fault(ASKED_FOR, "10 mm", error=MotionStopped):
        axis.driver.move_to_coordinate(10.0, stop_after(200, axis.machine))
    assert axis.machine.steps == 200 + 35
    assert axis.driver.current_coord == 2.35
    # The pause of the last pulse follows it, so the one before it is the last that shows.
    assert axis.pauses_s[-1] == pytest.approx(0.0049)
    steps_s = [abs(b - a) for a, b in zip(axis.pauses_s, axis.pauses_s[1:])]
    assert max(steps_s) <= 0.0001 + 1e-9
    axis.driver.move_to_coordinate(0.0, never)
    assert axis.machine.steps == 0


def test_a_stop_at_any_step_never_loses_the_count():
    chance = random.Random(20)
    axis = Axis(X_PARAMETERS)
    axis.driver.homing(never)
    for _ in range(draws(75)):
        target = chance.randrange(0, 1500) / 100
        axis.machine.pulses.clear()
        stop = (
            never if chance.random() < 0.3 else stop_after(chance.randrange(1, 500), axis.machine)
        )
        with contextlib.suppress(MotionStopped):
            axis.driver.move_to_coordinate(target, stop)
        assert round(axis.driver.current_coord * 100) == axis.machine.steps


@pytest.mark.parametrize("target, pressed", [(0.0, "14.99 mm"), (40.0, "25.01 mm")])
def test_the_endstop_pressed_during_a_move_ends_it_and_clears_homed(axis, target, pressed):
    axis.driver.move_to_coordinate(20.0, never)

    def press_after_5_mm():
        axis.machine.stuck = abs(axis.machine.steps - 2000) >= 500 or None
        return False

    with raises_fault(ENDSTOP, pressed, error=EndstopError):
        axis.driver.move_to_coordinate(target, press_after_5_mm)
    assert not axis.driver.homing_done
    with pytest.raises(NotHomedError):
        axis.driver.move_to_coordinate(5.0, never)


def test_a_second_motion_is_refused_while_one_is_under_way_and_works_after_a_failure(axis):
    def try_another():
        for motion in (lambda: axis.driver.move_to_coordinate(1.0, never), axis.driver.homing):
            with raises_fault(IN_USE, error=AxisBusyError):
                motion()
        raise RuntimeError("a fault in the middle of a move")

    with pytest.raises(RuntimeError, match="in the middle"):
        axis.driver.move_to_coordinate(5.0, try_another)
    assert not axis.driver.moving
    axis.driver.move_to_coordinate(5.0, never)
    assert axis.machine.steps == 500
