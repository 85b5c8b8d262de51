"""The axes: their leases, homings and moves, each alone and all together."""

from __future__ import annotations

import contextlib
import threading
from typing import Any, Callable, Collection, Dict, List, Mapping, Optional

from gpr20_common.faults import MAY_MOVE, PART_LOST, PART_SILENT
from gpr20_common.message import Fault, Message, in_a_row
from gpr20_main_control.errors import BLOCKED, DeviceError, NodeLostError
from gpr20_main_control.mid.devices.node_liveness import SILENCE_LIMIT_S
from gpr20_main_control.mid.devices.robot import (
    Axis,
    AxisReading,
    Lease,
    Position,
    zeros_of,
)
from gpr20_main_control.mid.waits import POLL_S, Interruption, Workers, result_of
from gpr20_survey.axes import AxisId, AxisParameters, ZeroEpoch
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED, ZERO_UNKNOWN
from gpr20_survey.plan.survey_points import axis_move_duration_s

# Nodes that are launched together, and links that were down, are connected within this time [s].
CONNECTION_LIMIT_S = 20.0
# A move may take this many times its planned duration, plus the extra time.
TIME_LIMIT_FACTOR = 1.5
TIME_LIMIT_EXTRA_S = 10.0
# Homing travels the length of the axis at the lowest speed and touches twice.
HOMING_TIME_FACTOR = 1.3
# An axis that rests at its target for this time has ended its move, even without a result [s].
LOST_RESULT_S = 1.0
# A lease is renewed this many times within its limit.
RENEWALS = 4
# A stop request reaches an axis within this time [s].
STOP_EFFECT_S = 0.2


class LeaseKeeper:
    """Has and renews the lease of one axis, in a thread of its own: no axis waits for another."""

    def __init__(self, axis: Axis, interruption: Interruption) -> None:
        """Reserve nothing yet; while nobody looks at the interruption, no lease is renewed."""
        self._axis, self._interruption = axis, interruption
        self._lock = threading.Lock()
        # Ends the thread that keeps the present lease; None without one.
        self._ended: Optional[threading.Event] = None

    def reserve(self) -> None:
        """Return when the axis is reserved; a lease that ended is replaced."""
        with self._lock:
            if self._ended is not None:
                return
            arguments = self._axis.lease(), threading.Event()
            self._ended = arguments[1]
        threading.Thread(target=self._keep, args=arguments, name="axis lease", daemon=True).start()

    def release(self) -> None:
        """Let others have the axis; returns at once."""
        with self._lock:
            ended, self._ended = self._ended, None
        if ended is not None:
            ended.set()

    def _keep(self, lease: Lease, ended: threading.Event) -> None:
        # Without an answer it ends by itself.
        with contextlib.suppress(DeviceError):
            while not ended.wait(lease.limit_s / RENEWALS):
                if not self._interruption.is_neglected:
                    self._axis.lease(lease.number)
            self._axis.lease(lease.number, release=True)
        with self._lock:
            if self._ended is ended:
                self._ended = None


class AxisMotion:
    """Moves one axis, and knows where it is.

    Attributes:
        axis_id: Which axis.
        axis: Its driver.
        may_move: Whether a motion that was begun here may not have ended yet; None before the
            first.
    """

    def __init__(
        self, axis_id: AxisId, axis: Axis, parameters: AxisParameters, interruption: Interruption
    ) -> None:
        self.axis_id, self.axis, self._parameters = axis_id, axis, parameters
        self.may_move: Optional[bool] = None
        self._interruption, self._clock = interruption, interruption.clock
        # Whether the axis has a target that it was not at.
        self._begun = False

    def fresh_reading(self, limit_s: float = SILENCE_LIMIT_S) -> Optional[AxisReading]:
        """Return the last reading of the axis; None if it is older than that [s]."""
        reading = self.axis.reading()
        return None if reading is None or reading.age_s > limit_s else reading

    def reading(self) -> AxisReading:
        """Return the last reading of the axis; a NodeLostError says that it does not publish."""
        reading = self.fresh_reading()
        if reading is None:
            raise NodeLostError(
                Message(
                    "the {axis} axis has not reported its position for {limit_s:g} s; check that "
                    "its driver runs",
                    axis=self.axis_id.value,
                    limit_s=SILENCE_LIMIT_S,
                    details=f"{self.axis_id.value}_axis/current_coord",
                ),
                fault=self._lost_fault,
            )
        return reading

    def homed_reading(self) -> AxisReading:
        """Return the last reading of the axis, or raise a DeviceError if it is not homed."""
        reading = self.reading()
        if not reading.homed:
            raise DeviceError(
                Message(
                    "the {axis} axis is not homed: its position is unknown; home it, or resume the "
                    "survey, which homes it",
                    axis=self.axis_id.value,
                ),
                fault=NOT_HOMED if self._parameters.finds_zero else ZERO_UNKNOWN,
            )
        return reading

    def home(self) -> None:
        """Home the axis; a DeviceError says why it could not be homed."""
        slow_s = 2.0 * self._parameters.max_step * self._parameters.travel_steps
        limit_s = HOMING_TIME_FACTOR * slow_s + TIME_LIMIT_EXTRA_S
        self.may_move = True
        try:
            self.axis.home(limit_s)
            self.may_move = False
        except DeviceError as error:
            self.may_move = error.message.may_move
            if isinstance(error, NodeLostError):
                raise
            raise DeviceError(
                Message(
                    "homing the {axis} axis failed: {reason}",
                    axis=self.axis_id.value,
                    reason=error.message,
                ),
                fault=BLOCKED,
            ) from error

    def begin(self, target: float) -> None:
        """Begin a move to a target [mm or deg]."""
        # A move of zero length is not sent: actionlib may lose the result of a goal that
        # ends before its sender has returned.
        self._begun = not self._is_at(target, self.reading())
        if not self._begun:
            return
        if not self._interruption.wait_until(self.axis.is_connected, CONNECTION_LIMIT_S):
            raise NodeLostError(
                Message("the {axis} axis driver is not connected", axis=self.axis_id.value),
                fault=self._lost_fault,
            )
        self.may_move = True
        self.axis.begin_move(target)

    def finish(self, target: float) -> None:
        """Return when the move has ended, and the axis reports that it rests at the target.

        A move whose result was lost has ended when the axis rests there for a while. A DeviceError
        says that the move failed, or that the axis rests elsewhere.
        """
        duration_s = axis_move_duration_s(self._parameters, target - self.reading().coordinate)
        moved_s, ended = self._clock.now_s(), not self._begun
        deadline_s = moved_s + TIME_LIMIT_FACTOR * duration_s + TIME_LIMIT_EXTRA_S
        while True:
            self.axis.received.clear()
            now_s = self._clock.now_s()
            if not ended and self._has_ended(target):
                ended, deadline_s = True, now_s + SILENCE_LIMIT_S
            self._interruption.check()
            if not self._rests_at(target):
                moved_s = now_s
            elif ended or now_s - moved_s > LOST_RESULT_S:
                if self._begun:
                    self.may_move = False
                return
            if now_s > deadline_s:
                raise DeviceError(
                    Message(
                        "the {axis} axis is at {coordinate:g} {unit} instead of {target:g} {unit}; "
                        "stop a paused survey and home the axis; then the survey can be resumed",
                        coordinate=self.homed_reading().coordinate,
                        **self._place(target),
                    ),
                    fault=BLOCKED if ended else AXIS_MAY_MOVE,
                )
            self._clock.wait_s(self.axis.received, POLL_S)

    @property
    def _lost_fault(self) -> Fault:
        return PART_LOST if self.may_move else PART_SILENT

    def _is_at(self, target: float, reading: AxisReading) -> bool:
        return abs(reading.coordinate - target) < 0.5 * self._parameters.step_size

    def _rests_at(self, target: float) -> bool:
        reading = self.reading()
        return reading.homed and not reading.moving and self._is_at(target, reading)

    def _place(self, target: float) -> Dict[str, Any]:
        return {"axis": self.axis_id.value, "target": target, "unit": self.axis_id.unit}

    def _has_ended(self, target: float) -> bool:
        try:
            ended = self.axis.move_ended()
        except DeviceError as error:
            # A stop makes moves fail, too.
            self._interruption.check()
            self.may_move = error.message.may_move
            lost = isinstance(error, NodeLostError)
            raise (NodeLostError if lost else DeviceError)(
                Message(
                    "the {axis} axis did not reach {target:g} {unit}: {reason}",
                    reason=error.message,
                    **self._place(target),
                ),
                fault=PART_SILENT if lost else BLOCKED,
            ) from error
        self.may_move = not ended
        return ended


class Positioner:
    """Reserves all axes; homes those that are used, moves them together, knows their position.

    Without contact to an axis that is used, a method raises a NodeLostError; after a stop, one that
    waits raises StopRequested.
    """

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        parameters: Mapping[AxisId, AxisParameters],
        interruption: Interruption,
        workers: Workers,
    ) -> None:
        """Reserve nothing yet; the axes with `parameters` are used."""
        self._leases = {axis_id: LeaseKeeper(axis, interruption) for axis_id, axis in axes.items()}
        self._axes = {
            axis_id: AxisMotion(axis_id, axes[axis_id], own, interruption)
            for axis_id, own in parameters.items()
        }
        self._interruption, self._clock = interruption, interruption.clock
        self._workers = workers

    def reserve(self) -> None:
        """Reserve the axes; a DeviceError says that another node has one, used or not."""
        for axis_id, lease in self._leases.items():
            try:
                lease.reserve()
            except NodeLostError:
                if axis_id in self._axes:
                    raise

    def release(self) -> None:
        """Let others have the axes; returns at once."""
        for lease in self._leases.values():
            lease.release()

    def check_alive(self) -> None:
        """Return when every axis has published a new reading; a starting axis has some time.

        An older reading may be from a node that has died since, and lost its zero with it. A
        DeviceError says which axis does not publish.
        """
        begun_s = self._clock.now_s()

        def all_publish() -> bool:
            limit_s = self._clock.now_s() - begun_s
            return all(axis.fresh_reading(limit_s) is not None for axis in self._axes.values())

        self._interruption.wait_until(all_publish, CONNECTION_LIMIT_S)
        self.reserve()
        try:
            self.zeros()
        except NodeLostError as error:
            # Its node is there, and waiting longer does not help.
            raise DeviceError(error.message) from error

    def reading(self, axis_id: AxisId) -> AxisReading:
        """Return the last reading of an axis; a DeviceError says that it is not homed."""
        return self._axes[axis_id].homed_reading()

    @property
    def lost_fault(self) -> Fault:
        """What a lost part means: until every axis rests, that hands have to stay clear."""
        return PART_LOST if any(axis.may_move for axis in self._axes.values()) else PART_SILENT

    def position(self) -> Position:
        """Return the position of the axes; a DeviceError names one that is not homed."""
        readings = {axis_id: axis.homed_reading() for axis_id, axis in self._axes.items()}
        x_mm, y_mm, z_deg = (readings[axis_id].coordinate for axis_id in AxisId)
        zeros = zeros_of({axis_id: reading.zero for axis_id, reading in readings.items()})
        return Position(x_mm, y_mm, z_deg, zeros)

    def zeros(self) -> Dict[AxisId, ZeroEpoch]:
        """Return the zero of each axis, or the last one of an axis that is not homed."""
        return {axis_id: axis.reading().zero for axis_id, axis in self._axes.items()}

    def home(self, again: Collection[AxisId] = ()) -> None:
        """Home together every axis that is not homed, or is to be homed again.

        After a NodeLostError axes may still be homing; of the others that fail, one is reported
        when all have ended.
        """
        self.reserve()
        pending = [
            axis
            for axis_id, axis in self._axes.items()
            if axis_id in again or not axis.reading().homed
        ]
        failures: List[DeviceError] = []
        with self._interruption.moving():
            for homing in [self._workers.begin(axis.home) for axis in pending]:
                try:
                    result_of(homing, self._interruption.check)
                except NodeLostError:
                    raise
                except DeviceError as error:
                    failures.append(error)
        self._interruption.check()
        if failures:
            raise failures[0]
        self._interruption.wait_until(
            lambda: all(axis.reading().homed for axis in pending), SILENCE_LIMIT_S
        )

    def move(
        self, targets: Mapping[AxisId, float], on_begun: Callable[[], None] = lambda: None
    ) -> None:
        """Move homed axes to their targets [mm or deg] and return when all of them rest there.

        Whatever is raised, all have been stopped. `on_begun` is called when they have begun.
        """
        self.reserve()
        try:
            with self._interruption.moving():
                for axis_id in targets:
                    self._axes[axis_id].homed_reading()
                for axis_id, target in targets.items():
                    self._axes[axis_id].begin(target)
                on_begun()
                for axis_id, target in targets.items():
                    self._axes[axis_id].finish(target)
        except BaseException:
            self.stop()
            raise

    def stop(self) -> None:
        """Stop every axis; returns at once."""
        for axis in self._axes.values():
            axis.axis.stop()

    def wait_for_rest(self, limit_s: float) -> Optional[Message]:
        """Wait until no axis moves after `stop`; return what may still move, None if nothing.

        An axis that does not publish is not waited for: its last reading is too old. If it was
        moved here, it is said to move: a driver that died moves nothing, because its motion ends
        without it, but one that is only unreachable looks the same, and people must be careful.
        """
        begun_s, never = self._clock.now_s(), threading.Event()
        while True:
            elapsed_s = self._clock.now_s() - begun_s
            readings = {axis: axis.fresh_reading() for axis in self._axes.values()}
            # Only readings well after the request show its effect.
            if elapsed_s > STOP_EFFECT_S and all(
                one is None or (one.age_s < elapsed_s - STOP_EFFECT_S and not one.moving)
                for one in readings.values()
            ):
                break
            if elapsed_s > limit_s:
                return Message("AN AXIS IS STILL MOVING: switch the motors off").with_fault(
                    MAY_MOVE
                )
            self._clock.wait_s(never, POLL_S)
        silent = []
        for axis, reading in readings.items():
            axis.may_move = axis.may_move and reading is None
            if axis.may_move is not None and reading is None:
                message = Message(
                    "the {axis} axis does not answer and may still move: switch the motors off",
                    axis=axis.axis_id.value,
                )
                silent.append(message.with_fault(MAY_MOVE))
        return in_a_row(silent) if silent else None
