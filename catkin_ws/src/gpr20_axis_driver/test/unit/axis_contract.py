"""What every controller of an axis must do, as tests; see docs/extend/axis_controller.md."""

from __future__ import annotations

import functools
import math
import threading
import time
from abc import ABC, abstractmethod
from typing import Callable, Type

from gpr20_axis_driver.faults import (
    AxisBusyError,
    AxisException,
    EndstopError,
    MotionStopped,
    NotHomedError,
    TravelError,
)
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_survey.axes.axis_parameters import AxisParameters

LIMIT_S = 20.0


class AxisContract(ABC):
    """Tests of a linear axis; a subclass whose name begins with Test opens its own axis.

    The axis may be simulated. Its travel should be short (20 mm), because a homing goes over all
    of it.
    """

    parameters: AxisParameters

    @abstractmethod
    def open_axis(self) -> AxisDriver:
        """Return the driver of an axis that is not homed and rests within its travel."""

    @abstractmethod
    def true_steps(self) -> int:
        """Return where the carriage really is [motor steps from coordinate zero]."""

    @abstractmethod
    def jam_endstop(self, pressed: bool) -> None:
        """Let the endstop stay pressed or open until the test ends."""

    @abstractmethod
    def break_contact(self) -> None:
        """End what moves the axis, as a cable that is pulled does."""

    @abstractmethod
    def restore_contact(self) -> None:
        """Plug the cable in again, and free the endstop."""

    def close_axis(self) -> None:
        """End a test."""
        self.axis.close(LIMIT_S)

    def setup_method(self) -> None:
        """Open the axis."""
        self.axis = self.open_axis()

    def teardown_method(self) -> None:
        """Restore everything and close the axis."""
        self.restore_contact()
        self.close_axis()

    def test_an_axis_that_is_not_homed_does_not_move(self) -> None:
        """The position is not known yet."""
        start = self.true_steps()
        _refused(NotHomedError, lambda: self.axis.move_to_coordinate(self._middle))
        assert self.true_steps() == start

    def test_homing_ends_at_the_same_place_within_the_travel(self) -> None:
        """Twice, the second time from the other end."""
        self.axis.homing()
        assert self.axis.homing_done and not self.axis.moving
        self._assert_exact()
        first = self.true_steps()
        self.axis.move_to_coordinate(self.parameters.max_coord)
        self.axis.homing()
        assert abs(self.true_steps() - first) <= 1
        self._assert_exact()

    def test_a_move_ends_exactly_at_its_target(self) -> None:
        """Long moves, one step, and no step."""
        self.axis.homing()
        middle, step = self._middle, self.parameters.step_size
        for target in (self.parameters.max_coord, middle, middle + step, middle + step, 0.0):
            self.axis.move_to_coordinate(target)
            assert self.axis.current_coord == self.parameters.coordinate_of(
                self.parameters.distance_steps(target)
            )
            self._assert_exact()

    def test_targets_outside_the_travel_are_refused_and_move_nothing(self) -> None:
        """Nor is there a number that is none."""
        self.axis.homing()
        start, step = self.true_steps(), self.parameters.step_size
        low, high = self.parameters.min_coord - step, self.parameters.max_coord + step
        for target in (low, high, math.nan, math.inf):
            _refused(TravelError, functools.partial(self.axis.move_to_coordinate, target))
        assert self.true_steps() == start

    def test_a_stopped_move_rests_before_its_target_with_an_exact_coordinate(self) -> None:
        """The next move starts from there."""
        self.axis.homing()
        end = self.parameters.max_coord
        _refused(MotionStopped, lambda: self.axis.move_to_coordinate(end, self._moved(200)))
        assert self.axis.current_coord < end
        self._assert_exact()
        assert self.axis.homing_done
        self.axis.move_to_coordinate(self._middle)
        self._assert_exact()

    def test_a_second_motion_is_refused_while_one_is_under_way(self) -> None:
        """It may be requested from another thread."""
        self.axis.homing()
        refused = threading.Event()

        def try_another() -> None:
            _refused(AxisBusyError, self.axis.homing)
            refused.set()

        def stop() -> bool:
            if not refused.is_set():
                thread = threading.Thread(target=try_another)
                thread.start()
                thread.join(LIMIT_S)
            return False

        self.axis.move_to_coordinate(self._middle, stop)
        assert refused.is_set()
        self._assert_exact()

    def test_a_homing_can_be_stopped_and_leaves_the_axis_not_homed(self) -> None:
        """It can be repeated."""
        self.axis.homing()
        self.axis.move_to_coordinate(self.parameters.max_coord)
        _refused(MotionStopped, lambda: self.axis.homing(self._moved(100)))
        assert not self.axis.homing_done
        rest = self.true_steps()
        assert rest > self.parameters.distance_steps(self.parameters.min_coord)
        self.axis.homing()
        self._assert_exact()

    def test_homing_is_bounded_if_the_endstop_never_closes(self) -> None:
        """The carriage is not pushed for ever, and the axis is not homed."""
        self.jam_endstop(pressed=False)
        _refused(EndstopError, self.axis.homing)
        assert not self.axis.homing_done
        self.restore_contact()
        self.axis.homing()
        self._assert_exact()

    def test_a_pressed_endstop_ends_a_move_and_the_axis_must_be_homed(self) -> None:
        """Steps were lost, or the switch or its cable is broken."""
        self.axis.homing()
        jam_at = self._moved(200)

        def press() -> bool:
            if jam_at():
                self.jam_endstop(pressed=True)
            return False

        end = self.parameters.max_coord
        _refused(AxisException, lambda: self.axis.move_to_coordinate(end, press))
        assert not self.axis.homing_done
        assert self.true_steps() < self.parameters.distance_steps(end)
        self.restore_contact()
        self.axis.homing()
        self._assert_exact()

    def test_a_lost_contact_ends_the_move_and_homing_helps_when_it_is_back(self) -> None:
        """The error says why; nothing moves without contact for long."""
        self.axis.homing()
        break_at = self._moved(200)
        broken = threading.Event()

        def cut() -> bool:
            if not broken.is_set() and break_at():
                self.break_contact()
                broken.set()
            return False

        end = self.parameters.max_coord
        _refused(AxisException, lambda: self.axis.move_to_coordinate(end, cut))
        assert not self.axis.homing_done
        assert self.axis.failure is not None
        self._wait_for_rest()
        assert self.true_steps() < self.parameters.distance_steps(end)
        self.restore_contact()
        self.axis.homing()
        assert self.axis.failure is None
        self._assert_exact()

    @property
    def _middle(self) -> float:
        middle = (self.parameters.min_coord + self.parameters.max_coord) / 2.0
        return self.parameters.coordinate_of(self.parameters.distance_steps(middle))

    def _moved(self, steps: int) -> Callable[[], bool]:
        """Return a function that returns whether the carriage has moved so far since its start."""
        start = self.true_steps()
        return lambda: abs(self.true_steps() - start) >= steps

    def _assert_exact(self) -> None:
        true = self.true_steps()
        known = self.parameters.distance_steps(self.axis.current_coord)
        assert known == true, f"the driver says step {known}, the carriage is at step {true}"

    def _wait_for_rest(self) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        resting_s = time.monotonic()
        steps = self.true_steps()
        while time.monotonic() - resting_s < 0.3:
            assert time.monotonic() < deadline_s, "the axis never came to rest"
            if self.true_steps() != steps:
                steps, resting_s = self.true_steps(), time.monotonic()
            time.sleep(0.01)


def _refused(error: Type[AxisException], motion: Callable[[], None]) -> None:
    try:
        motion()
    except error:
        return
    raise AssertionError(f"{error.__name__} was expected")
