"""The zero of an axis: with each homing and set_zero another one, or none that is known."""

from __future__ import annotations

import threading
from collections import defaultdict

import pytest
from axis_machine import X_PARAMETERS, Z_PARAMETERS, Axis
from fault_kit import raises_fault
from run_seed import draws

from gpr20_axis_driver.faults import (
    AxisBusyError,
    EndstopError,
    MotionStopped,
)
from gpr20_axis_driver.motion import never
from gpr20_survey.axes.axis_id import UNKNOWN_ZERO
from gpr20_survey.faults import NOT_HOMED

LIMIT_S = 30.0


def test_each_homing_and_each_set_zero_begins_another_zero_and_moves_do_not():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    assert axis.driver.position.zero == UNKNOWN_ZERO
    axis.driver.set_zero()
    first = axis.driver.position.zero
    axis.driver.move_to_coordinate(90.0, never)
    assert axis.driver.position.zero == first
    axis.driver.set_zero()
    second = axis.driver.position.zero
    axis.driver.homing(never)
    third = axis.driver.position.zero
    assert [one.number for one in (first, second, third)] == [1, 2, 3]
    assert 0 < first.time_us <= second.time_us
    # It only turned to the zero that was set then.
    assert third.time_us == second.time_us


def test_a_homing_that_fails_begins_no_zero():
    axis = Axis(X_PARAMETERS)
    axis.driver.homing(never)
    before = axis.driver.position.zero
    with pytest.raises(MotionStopped):
        axis.driver.homing(lambda: True)
    assert (axis.driver.position.zero, axis.driver.position.homed) == (before, False)


def test_no_reading_has_the_coordinate_of_one_zero_and_the_number_of_another():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    axis.driver.set_zero()
    reading, ended = threading.Event(), threading.Event()
    coordinates = defaultdict(list)

    def read():
        while not ended.is_set():
            position = axis.driver.position
            coordinates[position.zero.number].append(position.coordinate)
            reading.set()

    thread = threading.Thread(target=read)
    thread.start()
    assert reading.wait(LIMIT_S)
    while len(coordinates) < draws(25):
        axis.driver.set_zero()
        axis.driver.move_to_coordinate(1.8, never)
    ended.set()
    thread.join()
    # Within one zero the axis turns from 0 to 1.8 and never back.
    for number, seen in coordinates.items():
        assert seen == sorted(seen) and set(seen) <= {0.0, 1.8}, number


# Of an axis that has no endstop.


def test_a_homing_that_was_stopped_is_not_homed_and_goes_on_later():
    axis = Axis(Z_PARAMETERS, start_steps=50)
    axis.pulses.begin_zero(50, 0)
    with pytest.raises(MotionStopped):
        axis.driver.homing(lambda: len(axis.machine.pulses) >= 10)
    assert not axis.driver.homing_done
    axis.driver.homing(never)
    assert axis.machine.steps == 0
    assert (axis.driver.homing_done, axis.driver.current_coord) == (True, 0.0)


def test_the_zero_is_not_set_in_the_middle_of_a_turn():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    axis.driver.set_zero()

    def set_zero():
        with pytest.raises(AxisBusyError):
            axis.driver.set_zero()
        return False

    axis.driver.move_to_coordinate(90.0, set_zero)
    assert axis.driver.current_coord == 90.0


def test_an_axis_with_an_endstop_takes_its_zero_from_there_alone():
    with raises_fault(NOT_HOMED, error=EndstopError):
        Axis(X_PARAMETERS).driver.set_zero()
