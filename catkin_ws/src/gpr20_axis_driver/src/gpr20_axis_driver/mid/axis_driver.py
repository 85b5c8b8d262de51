"""One axis: its moves and its coordinate."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Callable, Iterator, Optional

from gpr20_axis_driver.faults import (
    PULSE_LATE,
    AxisBusyError,
    EndstopError,
    MotionStopped,
    NotHomedError,
    TravelError,
)
from gpr20_axis_driver.mid.homing import Homing
from gpr20_axis_driver.motion import (
    AxisMotions,
    Ending,
    Motion,
    MotionReport,
    StopRequested,
    never,
)
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, numeral
from gpr20_survey.axes import AxisParameters, Ramp, ZeroEpoch
from gpr20_survey.faults import ENDSTOP, NOT_HOMED, ZERO_UNKNOWN

SET_ZERO = Message(
    "turn the antennas to their mark and set the zero of this axis", details="service set_zero"
)
HOME_WITH_LESS_LOAD = Message("reduce this computer's load and home the axis")


@dataclass(frozen=True)
class AxisPosition:
    """Where an axis is.

    Attributes:
        coordinate: [mm or deg]; meaningful only if `homed`.
        homed: Whether the coordinate refers to the axis's zero.
        zero: Which zero that is.
    """

    coordinate: float
    homed: bool
    zero: ZeroEpoch


class AxisDriver:
    """Moves one axis and knows its coordinate. One motion at a time.

    Nothing is known about the position until the axis has been homed.

    Attributes:
        motions: Carries out its motions.
    """

    def __init__(
        self,
        parameters: AxisParameters,
        motions: AxisMotions,
        own_homing: Optional[Callable[[StopRequested], None]] = None,
        time_of_day_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        """Make the driver of an axis that is not homed.

        Args:
            parameters: The parameters of the axis.
            motions: Carries out its motions.
            own_homing: How its hardware finds the zero by itself; without it the driver does.
            time_of_day_us: Returns the time of day, for the zeros.
        """
        self.motions = motions
        self._parameters = parameters
        self._own_homing = own_homing
        self._ramp = Ramp(parameters.min_step, parameters.max_step, parameters.delta_step)
        self._time_of_day_us = time_of_day_us
        self._motion = threading.Lock()
        # Held while the zero changes: no reading mixes the coordinate of one with another.
        self._zero_changes = threading.RLock()
        self._homing_done = False
        self._last_motion = MotionReport(Ending.COMPLETE, 0, False)

    @property
    def current_coord(self) -> float:
        """Where the axis is [mm or deg]; meaningful only if `homing_done`."""
        return self._parameters.coordinate_of(self.motions.steps)

    @property
    def homing_done(self) -> bool:
        """Whether the coordinate refers to the axis's zero."""
        return self._homing_done and not self.motions.failure

    @property
    def position(self) -> AxisPosition:
        """Where the axis is, and since which zero."""
        with self._zero_changes:
            return AxisPosition(self.current_coord, self.homing_done, self.motions.zero)

    @property
    def moving(self) -> bool:
        """Whether a motion is being carried out now."""
        return self._motion.locked()

    @property
    def failure(self) -> Optional[Message]:
        """Why no motion is possible now; None if one is."""
        return self.motions.failure

    @property
    def last_motion(self) -> MotionReport:
        """The report of the last motion that had steps to make."""
        return self._last_motion

    def move_to_coordinate(self, target: float, stop_requested: StopRequested = never) -> None:
        """Move to a coordinate and return when the axis is at rest there.

        Args:
            target: Coordinate [mm or deg]; the nearest motor step is taken.
            stop_requested: Called repeatedly; once true, the axis slows down and stops.

        Raises:
            TravelError: The target is outside the axis; nothing moved.
            NotHomedError: The axis is not homed and did not move, or steps may have been lost.
            AxisBusyError: Another motion is under way.
            MotionStopped: A stop was requested; the coordinate is exact.
            EndstopError: The endstop was pressed; the axis must be homed again.
            PulseProcessError: The pulse process ended; the axis must be homed again.
            ControllerError: The controller failed; the axis must be homed again.
            AxisException: This node hung; the coordinate is exact.
        """
        with self._exclusive_motion():
            if not self.homing_done:
                raise NotHomedError(Message("the axis is not homed; home it before moving it"))
            self._go_to(self._steps_to(target), stop_requested)

    def homing(self, stop_requested: StopRequested = never) -> None:
        """Find the zero of the axis and stay there.

        An axis without endstop turns to its stored zero.

        Raises:
            AxisBusyError: Another motion is under way.
            EndstopError: The endstop is stuck, or out of reach; the axis is not homed.
            NotHomedError: There is no endstop and no stored position; nothing moved.
            MotionStopped: A stop was requested; the axis is not homed.
            PulseProcessError: The pulse process ended or cannot start; the axis is not homed.
            ControllerError: The controller failed or cannot be reached; the axis is not homed.
        """
        with self._exclusive_motion():
            self._homing_done = False
            self.motions.revive()
            if self._own_homing is not None:
                self._own_homing(stop_requested)
                self._begin_zero(self.motions.steps, self._time_of_day_us())
            elif self._parameters.sensor_pin is None:
                self._turn_to_stored_zero(stop_requested)
                # Nothing found it now: it is the zero that was set then.
                self._begin_zero(0, self.motions.zero.time_us)
            else:
                self._find_endstop(stop_requested)
                lowest = self._parameters.distance_steps(self._parameters.min_coord)
                self._begin_zero(lowest, self._time_of_day_us())

    def set_zero(self) -> None:
        """Make the present position of an axis without endstop its zero.

        Raises:
            AxisBusyError: A motion is under way.
            EndstopError: The axis has an endstop, which determines its zero.
            PulseProcessError: The pulse process cannot start.
        """
        if self._parameters.finds_zero:
            raise EndstopError(
                Message("the endstop determines the zero of this axis; home the axis"),
                fault=NOT_HOMED,
            )
        with self._exclusive_motion():
            self.motions.revive()
            self._begin_zero(0, self._time_of_day_us())

    def close(self, timeout_s: float) -> None:
        """Release the pins; no motion can begin afterwards.

        Args:
            timeout_s: How long to wait for the end of a motion under way [s].
        """
        # Never released: every request for a motion from now on is refused as busy.
        self._motion.acquire(timeout=timeout_s)
        self.motions.close()

    def _begin_zero(self, steps: int, time_us: int) -> None:
        with self._zero_changes:
            self._homing_done = False
            self.motions.begin_zero(steps, time_us)
            self._homing_done = True

    @contextmanager
    def _exclusive_motion(self) -> Iterator[None]:
        if not self._motion.acquire(blocking=False):
            raise AxisBusyError(
                Message("the axis is busy with another motion; stop it or wait for its end")
            )
        try:
            yield
        finally:
            self._motion.release()

    def _steps_to(self, target: float) -> int:
        low, high = self._parameters.min_coord, self._parameters.max_coord
        # Written so that NaN, which fails every comparison, is refused too.
        if not low <= target <= high:
            raise TravelError(
                Message(
                    "the target {target} {unit} is outside the axis, {low:g} to {high:g} {unit}",
                    target=numeral(target, ".12g"),
                    low=low,
                    high=high,
                    unit=self._parameters.unit,
                )
            )
        return self._parameters.distance_steps(target)

    def _find_endstop(self, stop_requested: StopRequested) -> None:
        known_steps = self.motions.steps if self.motions.trusted else None
        try:
            Homing(self._parameters, self._run).run(known_steps, stop_requested)
        except EndstopError:
            # The switch is not where the count says: the count, or the switch, is wrong.
            self.motions.distrust()
            raise

    def _turn_to_stored_zero(self, stop_requested: StopRequested) -> None:
        if not self.motions.trusted:
            raise NotHomedError(
                Message(
                    "the zero of this axis is unknown: it has no endstop, and its last position "
                    "is not stored; {advice}",
                    advice=SET_ZERO,
                ),
                fault=ZERO_UNKNOWN,
            )
        self._go_to(0, stop_requested)

    def _go_to(self, target_steps: int, stop_requested: StopRequested) -> None:
        distance = target_steps - self.motions.steps
        if distance == 0:
            return
        # Either way: a switch that closes on the way away from it is as broken as its cable.
        guarded = self._parameters.finds_zero
        motion = Motion(distance > 0, abs(distance), self._ramp, guarded=guarded)
        ending = self._run(motion, stop_requested).ending
        unit = self._parameters.unit
        if ending is Ending.PRESSED:
            self._homing_done = False
            self.motions.distrust()
            raise EndstopError(
                Message(
                    "the endstop was pressed at {coordinate:.12g} {unit}, where it should be open: "
                    "steps were lost or the switch is stuck; home the axis",
                    coordinate=self.current_coord,
                    unit=unit,
                ),
                fault=ENDSTOP,
            )
        if ending is Ending.STOPPED:
            raise MotionStopped(
                Message(
                    "stopped at {coordinate:.12g} {unit}, before the target {target:.12g} {unit}",
                    coordinate=self.current_coord,
                    target=self._parameters.coordinate_of(target_steps),
                    unit=unit,
                )
            )

    def _run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        report = self.motions.run(motion, stop_requested)
        if motion.steps > 0:
            self._last_motion = report
        if report.ending is Ending.GAP:
            self._homing_done = False
            finds_zero = self._parameters.finds_zero
            raise NotHomedError(
                Message(
                    "a pulse was {late_ms:.0f} ms late near {coordinate:.12g} {unit}, at a speed "
                    "at which the motor can lose steps: the position is no longer reliable; "
                    "{advice}",
                    late_ms=report.gap_s * 1e3,
                    coordinate=self.current_coord,
                    unit=self._parameters.unit,
                    advice=HOME_WITH_LESS_LOAD if finds_zero else SET_ZERO,
                ),
                fault=PULSE_LATE if finds_zero else ZERO_UNKNOWN,
            )
        return report
