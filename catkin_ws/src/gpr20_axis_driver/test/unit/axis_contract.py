"""What moves an axis must do, as tests; see docs/extend/axis_controller.md."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import Callable

import pytest

from gpr20_axis_driver.faults import AxisException, EndstopError, MotionStopped
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_survey.axes import AxisParameters

LIMIT_S = 100.0


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

    @pytest.fixture(autouse=True)
    def _opened(self):
        self.axis = self.open_axis()
        self.end = self.parameters.max_coord
        yield
        self.restore_contact()
        self.close_axis()

    def test_homing_ends_at_the_same_place_within_the_travel(self) -> None:
        """Twice, the second time from the other end."""
        self._home()
        first = self.true_steps()
        self.axis.move_to_coordinate(self.end)
        self._home()
        assert abs(self.true_steps() - first) <= 1

    def test_a_move_ends_exactly_at_its_target(self) -> None:
        """Long moves, one step, and no step."""
        self._home()
        middle, step = round(self.end / 2.0), self.parameters.step_size
        for target in (self.end, middle, middle + step, middle + step, 0.0):
            self.axis.move_to_coordinate(target)
            self._assert_exact(self.parameters.distance_steps(target))

    def test_a_stopped_move_rests_before_its_target_with_an_exact_coordinate(self) -> None:
        """The next move starts from there."""
        self._home()
        with pytest.raises(MotionStopped):
            self.axis.move_to_coordinate(self.end, self._moved(200))
        assert self.axis.current_coord < self.end and self.axis.homing_done
        self._assert_exact(self.true_steps())
        self.axis.move_to_coordinate(1.0)
        self._assert_exact(self.parameters.distance_steps(1.0))

    def test_a_homing_can_be_stopped_and_leaves_the_axis_not_homed(self) -> None:
        """It can be repeated."""
        self._home()
        self.axis.move_to_coordinate(self.end)
        with pytest.raises(MotionStopped):
            self.axis.homing(self._moved(100))
        assert self.true_steps() > self.parameters.distance_steps(self.parameters.min_coord)
        self._assert_homing_helps()

    def test_homing_is_bounded_if_the_endstop_never_closes(self) -> None:
        """The carriage is not pushed for ever, and the axis is not homed."""
        self.jam_endstop(pressed=False)
        with pytest.raises(EndstopError):
            self.axis.homing()
        self._assert_homing_helps()

    def test_a_pressed_endstop_ends_a_move_and_the_axis_must_be_homed(self) -> None:
        """Steps were lost, or the switch or its cable is broken."""
        self._home()
        with pytest.raises(AxisException):
            self.axis.move_to_coordinate(self.end, self._then(lambda: self.jam_endstop(True)))
        assert self.true_steps() < self.parameters.distance_steps(self.end)
        self._assert_homing_helps()

    def test_a_lost_contact_ends_the_move_and_homing_helps_when_it_is_back(self) -> None:
        """The error says why; nothing moves without contact for long."""
        self._home()
        with pytest.raises(AxisException):
            self.axis.move_to_coordinate(self.end, self._then(self.break_contact))
        assert self.axis.failure is not None
        self._wait_for_rest()
        assert self.true_steps() < self.parameters.distance_steps(self.end)
        self._assert_homing_helps()
        assert self.axis.failure is None

    def _home(self) -> None:
        self.axis.homing()
        assert self.axis.homing_done and not self.axis.moving
        self._assert_exact(self.true_steps())

    def _assert_homing_helps(self) -> None:
        assert not self.axis.homing_done
        self.restore_contact()
        self._home()

    def _moved(self, steps: int) -> Callable[[], bool]:
        """Return a function that returns whether the carriage has moved so far since its start."""
        start = self.true_steps()
        return lambda: abs(self.true_steps() - start) >= steps

    def _then(self, act: Callable[[], None]) -> Callable[[], bool]:
        """Return what requests no stop, but acts once when the carriage has moved a little."""
        moved, acts = self._moved(200), iter([act])

        def poll() -> bool:
            if moved():
                next(acts, lambda: None)()
            return False

        return poll

    def _assert_exact(self, steps: int) -> None:
        known = self.parameters.distance_steps(self.axis.current_coord)
        assert (known, self.true_steps()) == (steps, steps), "of the driver and of the carriage"

    def _wait_for_rest(self) -> None:
        deadline_s = time.monotonic() + LIMIT_S
        resting_s, steps = time.monotonic(), self.true_steps()
        while time.monotonic() - resting_s < 1.0:
            assert time.monotonic() < deadline_s, "the axis never came to rest"
            if self.true_steps() != steps:
                resting_s, steps = time.monotonic(), self.true_steps()
            time.sleep(0.01)
