"""Finding the zero of a linear axis with its endstop."""

from __future__ import annotations

from typing import Callable

from gpr20_axis_driver.axis_exceptions import EndstopError
from gpr20_axis_driver.low.endstop_interface import EndstopInterface
from gpr20_axis_driver.mid.axis_parameters import AxisParameters

# Asked at every step: whether the motion shall end now.
StopRequested = Callable[[], bool]
# Steps at the lowest speed: (forward, most steps, until, stop requested) -> steps made.
SlowSteps = Callable[[bool, int, Callable[[], bool], StopRequested], int]

# A carriage may stand a little beyond its travel when homing begins.
TRAVEL_MARGIN = 1.05
# A pressed switch must open within this many back-offs.
RELEASE_BACKOFFS = 5
# Two touches of a sound switch happen at the same place to within this part of a back-off.
TOUCH_TOLERANCE = 0.25


class Homing:
    """Touch the endstop, back off, touch again, and back off to the zero.

    Everything happens at the lowest speed and is bounded by the length of the axis.
    """

    def __init__(
        self, parameters: AxisParameters, endstop: EndstopInterface, slow_steps: SlowSteps
    ) -> None:
        self._unit = parameters.unit
        self._step_size = parameters.step_size
        self._travel_steps = parameters.travel_steps
        self._backoff_steps = max(1, parameters.distance_steps(parameters.homing_backoff))
        self._endstop = endstop
        self._slow_steps = slow_steps

    def run(self, stop: StopRequested) -> None:
        """Carry out the whole homing; the axis then stands at its zero.

        Raises:
            EndstopError: The switch is stuck or cannot be reached.
            MotionStopped: A stop was requested.
        """
        if self._endstop.is_pressed():
            self._release(stop)
        self._touch(int(self._travel_steps * TRAVEL_MARGIN) + self._backoff_steps, stop)
        self._back_off(stop)
        made = self._touch(2 * self._backoff_steps, stop)
        if abs(made - self._backoff_steps) > max(1, int(TOUCH_TOLERANCE * self._backoff_steps)):
            raise EndstopError(
                f"the endstop switched {made * self._step_size:g} {self._unit} from where the "
                f"carriage had backed off by {self._backoff_steps * self._step_size:g} "
                f"{self._unit}: it does not switch at one place; check the switch and the belt"
            )
        self._back_off(stop)

    def _touch(self, most_steps: int, stop: StopRequested) -> int:
        made = self._slow_steps(False, most_steps, self._endstop.is_pressed, stop)
        if not self._endstop.is_pressed():
            raise EndstopError(
                f"the endstop was not reached within {most_steps * self._step_size:g} "
                f"{self._unit}: it is stuck open, unplugged, or the motor does not turn; check "
                "the switch, its cable and the motor"
            )
        return made

    def _back_off(self, stop: StopRequested) -> None:
        self._slow_steps(True, self._backoff_steps, lambda: False, stop)
        if self._endstop.is_pressed():
            raise EndstopError(
                f"the endstop is still pressed {self._backoff_steps * self._step_size:g} "
                f"{self._unit} away from it: it is stuck closed or the motor does not turn; "
                "check the switch, its cable and the motor"
            )

    def _release(self, stop: StopRequested) -> None:
        most_steps = RELEASE_BACKOFFS * self._backoff_steps
        self._slow_steps(True, most_steps, lambda: not self._endstop.is_pressed(), stop)
        if self._endstop.is_pressed():
            raise EndstopError(
                f"the endstop stayed pressed for {most_steps * self._step_size:g} {self._unit}: "
                "it is stuck closed, short-circuited, or the motor does not turn; check the "
                "switch, its cable and the motor"
            )
