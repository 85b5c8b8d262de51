"""Finding the zero of a linear axis with its endstop."""

from __future__ import annotations

from typing import Callable, Optional

from gpr20_axis_driver.faults import EndstopError, MotionStopped
from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested, Until
from gpr20_common.message import Message
from gpr20_survey.axes import HOMING_BACKOFFS, AxisParameters, Ramp

RunMotion = Callable[[Motion, StopRequested], MotionReport]

# A carriage may be a little beyond its travel when homing begins.
TRAVEL_MARGIN = 1.05
# Two touches of a working switch happen at the same place to within this part of a back-off.
TOUCH_TOLERANCE = 0.25


class Homing:
    """Touch the endstop, back off, touch again, and back off to the zero.

    Everything happens at the lowest speed. The first touch is bounded by the position, where it
    is known, and by the length of the axis: an endstop that never closes must not let the carriage
    push against its end for longer than necessary.
    """

    def __init__(self, parameters: AxisParameters, run: RunMotion) -> None:
        self._unit = parameters.unit
        self._step_size = parameters.step_size
        self._whole_steps = int(parameters.travel_steps * TRAVEL_MARGIN)
        self._zero_steps = parameters.distance_steps(parameters.min_coord)
        self._margin_steps = parameters.distance_steps(parameters.homing_margin)
        self._backoff_steps = max(1, parameters.distance_steps(parameters.homing_backoff))
        # At the lowest speed the axis can stop on any step, so no ramp is needed.
        self._slow = Ramp(parameters.max_step, parameters.max_step, parameters.delta_step)
        self._run = run

    def run(self, known_steps: Optional[int], stop: StopRequested) -> None:
        """Carry out the whole homing; the axis is then at rest at its zero.

        Args:
            known_steps: Where the axis is [motor steps from coordinate zero]; None if unknown.
            stop: Whether to end the homing.

        Raises:
            EndstopError: The switch is stuck or cannot be reached.
            MotionStopped: A stop was requested.
        """
        if self._step(True, 0, Until.NOTHING, stop).endstop_pressed:
            self._leave(HOMING_BACKOFFS * self._backoff_steps, Until.RELEASED, stop)
        self._touch(self._first_touch_steps(known_steps), stop)
        self._back_off(stop)
        made = self._touch(2 * self._backoff_steps, stop)
        if abs(made - self._backoff_steps) > max(1, int(TOUCH_TOLERANCE * self._backoff_steps)):
            raise EndstopError(
                Message(
                    "the endstop switched again after {distance:g} {unit}, although the carriage "
                    "had backed off by {backoff:g} {unit}: it does not always switch at the same "
                    "place; check the switch and the belt",
                    distance=made * self._step_size,
                    backoff=self._backoff_steps * self._step_size,
                    unit=self._unit,
                )
            )
        self._back_off(stop)

    def _first_touch_steps(self, known_steps: Optional[int]) -> int:
        """Return the most steps to the switch, which is a back-off below the zero."""
        steps = self._whole_steps
        if known_steps is not None:
            above_zero = max(0, known_steps - self._zero_steps)
            steps = min(steps, above_zero + self._margin_steps)
        return steps + self._backoff_steps

    def _touch(self, most_steps: int, stop: StopRequested) -> int:
        report = self._step(False, most_steps, Until.PRESSED, stop)
        if not report.endstop_pressed:
            raise EndstopError(
                Message(
                    "the endstop was not reached within {distance:g} {unit}: it is stuck open or "
                    "unplugged, the motor has no power or does not turn, or the axis was moved by "
                    "hand; check the switch, its cable and the motor; the next homing searches the "
                    "whole axis",
                    distance=most_steps * self._step_size,
                    unit=self._unit,
                )
            )
        return report.steps_made

    def _back_off(self, stop: StopRequested) -> None:
        self._leave(self._backoff_steps, Until.NOTHING, stop)

    def _leave(self, most_steps: int, until: Until, stop: StopRequested) -> None:
        if self._step(True, most_steps, until, stop).endstop_pressed:
            raise EndstopError(
                Message(
                    "the endstop was still pressed after {distance:g} {unit}: it is stuck closed "
                    "or short-circuited, or the motor does not turn; check the switch, its cable "
                    "and the motor",
                    distance=most_steps * self._step_size,
                    unit=self._unit,
                )
            )

    def _step(
        self, forward: bool, most_steps: int, until: Until, stop: StopRequested
    ) -> MotionReport:
        report = self._run(Motion(forward, most_steps, self._slow, until), stop)
        if report.ending is Ending.STOPPED:
            raise MotionStopped(Message("homing was stopped; the axis is not homed"))
        return report
