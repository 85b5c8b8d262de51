"""Each homing and each set_zero begins another zero."""

from __future__ import annotations

import threading
from collections import defaultdict

import pytest
from axis_machine import X_PARAMETERS, Z_PARAMETERS, Axis

from gpr20_axis_driver.axis_exceptions import MotionStopped
from gpr20_axis_driver.motion import never
from gpr20_survey.axes.zero_epoch import UNKNOWN_ZERO

LIMIT_S = 10.0


def test_the_zero_of_an_axis_that_was_never_homed_is_not_known():
    assert Axis(X_PARAMETERS).driver.position.zero == UNKNOWN_ZERO


def test_each_homing_and_each_set_zero_begins_another_zero_and_moves_do_not():
    axis = Axis(Z_PARAMETERS, start_steps=0)
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
    while len(coordinates) < 100:
        axis.driver.set_zero()
        axis.driver.move_to_coordinate(1.8, never)
    ended.set()
    thread.join()
    # Within one zero the axis turns from 0 to 1.8 and never back.
    for number, seen in coordinates.items():
        assert seen == sorted(seen) and set(seen) <= {0.0, 1.8}, number
