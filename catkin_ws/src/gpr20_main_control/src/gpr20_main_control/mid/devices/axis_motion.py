"""One axis: its lease, its homing and its moves."""

from __future__ import annotations

import contextlib
import threading
from typing import Any, Callable, Dict, Optional

from gpr20_common.faults import PART_LOST, PART_SILENT
from gpr20_common.message import Fault, Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.devices.node_liveness import SILENCE_LIMIT_S
from gpr20_main_control.mid.devices.robot import Axis, AxisReading, Lease, MoveOutcome
from gpr20_main_control.mid.waits import Attention, Interruption
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED
from gpr20_survey.plan.survey_cost import axis_move_duration_s

# An axis publishes at 10 Hz at rest; without a reading for this time there is no contact [s].
# Over a link that loses packets, a single reading may be late by seconds.
READING_LIMIT_S = SILENCE_LIMIT_S
# Nodes that are launched together, and links that were down, are connected within this time [s].
CONNECTION_LIMIT_S = 20.0
# A move may take this many times its planned duration, plus the extra time.
TIME_LIMIT_FACTOR = 1.5
TIME_LIMIT_EXTRA_S = 10.0
# Homing travels the length of the axis at the lowest speed and touches twice.
HOMING_TIME_FACTOR = 1.3
# How often a waiting survey checks for a stop request [s].
POLL_S = 0.05
# An axis that rests at its target for this time has ended its move, even without a result [s].
LOST_RESULT_S = 1.0
# A lease is renewed this many times within its limit.
RENEWALS = 4


def wait_until(condition: Callable[[], bool], limit_s: float, interruption: Interruption) -> bool:
    """Wait for a condition, at most so long [s]; return whether it is true."""
    deadline_s = interruption.clock.now_s() + limit_s
    while not condition():
        if interruption.clock.now_s() > deadline_s:
            return False
        interruption.wait_s(POLL_S)
    return True


class LeaseKeeper:
    """Has and renews the lease of one axis, in a thread of its own: no axis waits for another."""

    def __init__(self, axis: Axis, attention: Attention) -> None:
        """Reserve nothing yet; without `attention` while axes move, no lease is renewed."""
        self._axis = axis
        self._attention = attention
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
                if not self._attention.lacks:
                    self._axis.lease(lease.number)
            self._axis.lease(lease.number, release=True)
        with self._lock:
            if self._ended is ended:
                self._ended = None


class AxisMotion:
    """Moves one axis, and knows where it is.

    Attributes:
        axis_id: Which axis.
        may_move: Whether a motion that was begun here may not have ended yet; None before the
            first.
    """

    def __init__(
        self, axis_id: AxisId, axis: Axis, parameters: AxisParameters, interruption: Interruption
    ) -> None:
        self.axis_id = axis_id
        self.may_move: Optional[bool] = None
        self._axis, self._parameters = axis, parameters
        self._interruption, self._clock = interruption, interruption.clock
        # Whether the axis has a target that it was not at.
        self._begun = False

    def fresh_reading(self, limit_s: float = READING_LIMIT_S) -> Optional[AxisReading]:
        """Return the last reading of the axis; None if it is older than that [s]."""
        reading = self._axis.reading()
        return None if reading is None or reading.age_s > limit_s else reading

    def reading(self) -> AxisReading:
        """Return the last reading of the axis.

        Raises:
            NodeLostError: The axis does not publish.
        """
        reading = self.fresh_reading()
        if reading is None:
            raise NodeLostError(
                Message(
                    "the {axis} axis has not reported its position for {limit_s:g} s; check that "
                    "its driver runs",
                    axis=self.axis_id.value,
                    limit_s=READING_LIMIT_S,
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
                    "the {axis} axis is not homed: its position is unknown; resume the survey to "
                    "home it",
                    axis=self.axis_id.value,
                ),
                fault=NOT_HOMED,
            )
        return reading

    def stop(self) -> None:
        """End any motion; returns at once."""
        self._axis.stop()

    def home(self) -> None:
        """Home the axis; a DeviceError says why it could not be homed."""
        slow_s = 2.0 * self._parameters.max_step * self._parameters.travel_steps
        limit_s = HOMING_TIME_FACTOR * slow_s + TIME_LIMIT_EXTRA_S
        self.may_move = True
        try:
            self._axis.home(limit_s)
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
                fault=faults.BLOCKED,
            ) from error

    def begin(self, target: float) -> None:
        """Begin a move to a target [mm or deg].

        Raises:
            NodeLostError: The driver is not connected.
        """
        # A move of zero length is not sent: actionlib may lose the result of a goal that
        # ends before its sender has returned.
        self._begun = not self._is_at(target, self.reading())
        if not self._begun:
            return
        if not wait_until(self._axis.is_connected, CONNECTION_LIMIT_S, self._interruption):
            raise NodeLostError(
                Message("the {axis} axis driver is not connected", axis=self.axis_id.value),
                fault=self._lost_fault,
            )
        self.may_move = True
        self._axis.begin_move(target)

    def finish(self, target: float) -> None:
        """Return when the move has ended, and the axis reports that it rests at the target.

        A move whose result was lost has ended when the axis rests there for a while.

        Raises:
            DeviceError: The move failed, or the axis rests elsewhere.
            NodeLostError: There is no contact with the axis.
        """
        distance = target - self.reading().coordinate
        duration_s = axis_move_duration_s(self._parameters, distance)
        deadline_s = self._clock.now_s() + TIME_LIMIT_FACTOR * duration_s + TIME_LIMIT_EXTRA_S
        ended = not self._begun
        rests_since_s: Optional[float] = None
        while True:
            self._axis.received.clear()
            outcome, now_s = self._axis.move_outcome(), self._clock.now_s()
            # After the outcome: a stop makes moves fail, too.
            self._interruption.check()
            if outcome is not None and not ended:
                self._check_success(outcome, target)
                ended, deadline_s = True, now_s + READING_LIMIT_S
            if not self._rests_at(target):
                rests_since_s = None
            elif ended:
                return
            elif rests_since_s is None:
                rests_since_s = now_s
            elif now_s - rests_since_s > LOST_RESULT_S:
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
                    fault=faults.BLOCKED if ended else AXIS_MAY_MOVE,
                )
            self._clock.wait_s(self._axis.received, POLL_S)

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

    def _check_success(self, outcome: MoveOutcome, target: float) -> None:
        self.may_move = outcome.message.may_move
        if outcome.success:
            return
        lost = outcome.contact_lost
        raise (NodeLostError if lost else DeviceError)(
            Message(
                "the {axis} axis did not reach {target:g} {unit}: {reason}",
                reason=outcome.message,
                **self._place(target),
            ),
            fault=PART_SILENT if lost else faults.BLOCKED,
        )
