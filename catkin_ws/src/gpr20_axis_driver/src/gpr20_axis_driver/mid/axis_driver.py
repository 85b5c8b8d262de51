"""One axis: moves, and the coordinate that they lead to."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Callable, Iterable, Iterator, Optional

from gpr20_axis_driver.axis_exceptions import (
    AxisBusyError,
    EndstopError,
    MotionStopped,
    NotHomedError,
)
from gpr20_axis_driver.low.endstop_interface import EndstopInterface
from gpr20_axis_driver.low.stepper_interface import StepperInterface
from gpr20_axis_driver.mid.axis_parameters import AxisParameters
from gpr20_axis_driver.mid.homing import Homing, StopRequested
from gpr20_axis_driver.mid.ramp import Ramp
from gpr20_common.low.clock import Clock


class AxisDriver:
    """Moves one axis and counts its steps. One motion at a time.

    Nothing is known about the position until the axis has been homed.
    """

    def __init__(
        self,
        parameters: AxisParameters,
        stepper: StepperInterface,
        endstop: Optional[EndstopInterface],
        clock: Clock,
    ) -> None:
        self._parameters = parameters
        self._stepper = stepper
        self._endstop = endstop
        self._clock = clock
        self._ramp = Ramp(parameters.min_step, parameters.max_step, parameters.delta_step)
        self._motion = threading.Lock()
        self._steps = 0
        self._homed = False

    @property
    def coordinate(self) -> float:
        """Where the axis is [mm or deg]; meaningful only if it is homed."""
        return self._parameters.coordinate_of(self._steps)

    @property
    def homed(self) -> bool:
        """Whether the coordinate is referred to the axis's zero."""
        return self._homed

    @property
    def moving(self) -> bool:
        """Whether a motion is being carried out now."""
        return self._motion.locked()

    def move_to(self, target: float, stop_requested: StopRequested) -> None:
        """Move to a coordinate and return when the axis stands there.

        Args:
            target: Coordinate [mm or deg]; the nearest motor step is taken.
            stop_requested: Asked at every step; once true the axis slows down and stops.

        Raises:
            TravelError: The target is outside the axis; nothing moved.
            NotHomedError: The axis has not been homed; nothing moved.
            AxisBusyError: Another motion is under way.
            MotionStopped: A stop was requested; the coordinate is exact.
            EndstopError: The endstop was pressed; the axis must be homed again.
        """
        with self._exclusive_motion():
            if not self._homed:
                raise NotHomedError("the axis is not homed; home it before moving it")
            target_steps = self._parameters.steps_to(target)
            distance = target_steps - self._steps
            self._step_along(distance > 0, self._ramp.pauses_s(abs(distance)), stop_requested)
            if self._steps != target_steps:
                raise MotionStopped(
                    f"stopped at {self.coordinate:.12g} {self._parameters.unit}, before the "
                    f"target {target:.12g} {self._parameters.unit}"
                )

    def home(self, stop_requested: StopRequested) -> None:
        """Find the zero of the axis and stand there.

        An axis without endstop takes the place where it stands as its zero: the
        antennas must have been turned to their mark before.

        Raises:
            AxisBusyError: Another motion is under way.
            EndstopError: The endstop is stuck, or out of reach; the axis is not homed.
            MotionStopped: A stop was requested; the axis is not homed.
        """
        with self._exclusive_motion():
            self._homed = False
            if self._endstop is None:
                self._steps = 0
            else:
                homing = Homing(self._parameters, self._endstop, self._step_slowly)
                homing.run(stop_requested)
                self._steps = self._parameters.distance_steps(self._parameters.min_coord)
            self._homed = True

    def close(self, timeout_s: float) -> None:
        """Release the pins; no motion can begin any more.

        Args:
            timeout_s: How long to wait for the end of a motion under way [s].
        """
        # Never released: whoever asks for a motion from now on finds the axis busy.
        self._motion.acquire(timeout=timeout_s)
        self._stepper.close()
        if self._endstop is not None:
            self._endstop.close()

    @contextmanager
    def _exclusive_motion(self) -> Iterator[None]:
        if not self._motion.acquire(blocking=False):
            raise AxisBusyError("the axis is busy with another motion; stop it or wait for its end")
        try:
            yield
        finally:
            self._motion.release()

    def _step_along(
        self, forward: bool, pauses_s: Iterable[float], stop_requested: StopRequested
    ) -> None:
        """Step through the pauses; slow down and return early once a stop is requested."""
        guard = None if forward else self._endstop
        self._stepper.set_direction(forward)
        due_s = self._clock.now_s()
        for pause_s in pauses_s:
            due_s = self._step(forward, due_s, pause_s, guard)
            if stop_requested():
                for braking_pause_s in self._ramp.braking_pauses_s(pause_s):
                    due_s = self._step(forward, due_s, braking_pause_s, guard)
                return

    def _step(
        self, forward: bool, due_s: float, pause_s: float, guard: Optional[EndstopInterface]
    ) -> float:
        if guard is not None and guard.is_pressed():
            self._homed = False
            raise EndstopError(
                f"the endstop was pressed at {self.coordinate:.12g} {self._parameters.unit}, where "
                "it should be open: steps were lost or the switch is stuck; home the axis"
            )
        self._stepper.raise_step()
        # Counted at the edge on which the motor moves, so a stop in between loses nothing.
        self._steps += 1 if forward else -1
        return self._stepper.finish_step(due_s, pause_s)

    def _step_slowly(
        self,
        forward: bool,
        steps: int,
        until: Callable[[], bool],
        stop_requested: StopRequested,
    ) -> int:
        """Step at the lowest speed until a condition holds; return the steps made.

        At the lowest speed the axis can stop on any step, so no ramp is needed.
        """
        self._stepper.set_direction(forward)
        due_s = self._clock.now_s()
        for made in range(steps):
            if until():
                return made
            if stop_requested():
                raise MotionStopped("homing was stopped; the axis is not homed")
            due_s = self._step(forward, due_s, self._parameters.max_step, None)
        return steps
