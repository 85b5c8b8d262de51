"""The three axes moving together."""

from __future__ import annotations

import threading
from functools import partial
from typing import Callable, Collection, Dict, List, Mapping, Optional

from gpr20_common.faults import MAY_MOVE, PART_LOST, PART_SILENT
from gpr20_common.message import Fault, Message, in_a_row
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.devices.axis_leases import AxisLeases
from gpr20_main_control.mid.devices.node_liveness import SILENCE_LIMIT_S
from gpr20_main_control.mid.devices.robot import Axis, AxisReading, Position, zeros_of
from gpr20_main_control.mid.waits import Interruption, Workers, result_of
from gpr20_survey.axes.axis_id import AxisId, ZeroEpoch
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED
from gpr20_survey.plan.survey_cost import axis_move_duration_s
from gpr20_survey.plan.survey_points import SurveyPoint

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
# A stop request reaches an axis within this time [s].
STOP_EFFECT_S = 0.2
# An axis that rests at its target for this time has ended its move, even without a result [s].
LOST_RESULT_S = 1.0


class Positioner:
    """Homes the axes, moves them together, and knows their position."""

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        parameters: Dict[AxisId, AxisParameters],
        interruption: Interruption,
        workers: Workers,
        leases: AxisLeases,
    ) -> None:
        self._leases, self._workers = leases, workers
        self._axes, self._parameters = axes, parameters
        self._interruption = interruption
        # Of each axis that was moved here: whether that motion may not have ended yet.
        self._may_move: Dict[AxisId, bool] = {}
        self._clock = interruption.clock

    def check_alive(self) -> None:
        """Return when every axis has published a new reading; a starting axis has some time.

        An older reading may be from a node that has died since, and lost its zero with it.

        Raises:
            DeviceError: An axis does not publish.
            StopRequested: A stop of the survey was requested.
        """
        begun_s = self._clock.now_s()

        def all_publish() -> bool:
            limit_s = min(self._clock.now_s() - begun_s, READING_LIMIT_S)
            return all(_is_younger(axis.reading(), limit_s) for axis in self._axes.values())

        self._wait(all_publish, CONNECTION_LIMIT_S)
        self._leases.ensure(self._axes)
        try:
            self.zeros()
        except NodeLostError as error:
            # Its node is there, and waiting longer does not help.
            raise DeviceError(error.message) from error

    def reading(self, axis_id: AxisId) -> AxisReading:
        """Return the last reading of an axis.

        Raises:
            NodeLostError: The axis does not publish.
        """
        reading = self._axes[axis_id].reading()
        if reading is None or reading.age_s > READING_LIMIT_S:
            raise NodeLostError(
                Message(
                    "the {axis} axis has not reported its position for {limit_s:g} s; check that "
                    "its driver runs",
                    axis=axis_id.value,
                    limit_s=READING_LIMIT_S,
                    details=f"{axis_id.value}_axis/current_coord",
                ),
                fault=self._lost_fault(axis_id),
            )
        return reading

    @property
    def lost_fault(self) -> Fault:
        """What a lost part means: until every axis rests, that hands have to stay clear."""
        return PART_LOST if any(self._may_move.values()) else PART_SILENT

    def _lost_fault(self, axis_id: AxisId) -> Fault:
        return PART_LOST if self._may_move.get(axis_id) else PART_SILENT

    def position(self) -> Position:
        """Return the position of the axes.

        Raises:
            NodeLostError: An axis does not publish.
            DeviceError: An axis is not homed.
        """
        readings = {axis_id: self.reading(axis_id) for axis_id in self._axes}
        for axis_id, reading in readings.items():
            _refuse_not_homed(axis_id, reading)
        x_mm, y_mm, z_deg = (readings[axis_id].coordinate for axis_id in AxisId)
        zeros = zeros_of({axis_id: reading.zero for axis_id, reading in readings.items()})
        return Position(x_mm, y_mm, z_deg, zeros)

    def zeros(self) -> Dict[AxisId, ZeroEpoch]:
        """Return the zero of each axis, or the last one of an axis that is not homed.

        Raises:
            NodeLostError: An axis does not publish.
        """
        return {axis_id: self.reading(axis_id).zero for axis_id in self._axes}

    def home(self, again: Collection[AxisId] = ()) -> List[AxisId]:
        """Home together every axis that is not homed, or is to be homed again; return which.

        Raises:
            DeviceError: An axis could not be homed.
            NodeLostError: A node is lost; axes may still be homing.
            StopRequested: A stop of the survey was requested.
        """
        pending = [one for one in self._axes if one in again or not self.reading(one).homed]
        self._leases.ensure(pending)
        failures = []
        with self._interruption.attention.needed():
            homings = [self._workers.begin(partial(self._home, axis_id)) for axis_id in pending]
            for homing in homings:
                try:
                    result_of(homing, self._interruption.check)
                except NodeLostError:
                    raise
                except DeviceError as error:
                    failures.append(error)
        self._interruption.check()
        if failures:
            raise failures[0]
        self._wait(lambda: all(self.reading(axis_id).homed for axis_id in pending))
        return pending

    def move_to(self, point: SurveyPoint, on_begun: Callable[[], None]) -> None:
        """Move the axes, which must be homed, to a point, as `move` does."""
        self.position()
        self.move({AxisId.X: point.x_mm, AxisId.Y: point.y_mm, AxisId.Z: point.z_deg}, on_begun)

    def move(
        self, targets: Mapping[AxisId, float], on_begun: Callable[[], None] = lambda: None
    ) -> None:
        """Move axes to their targets [mm or deg] and return when all of them rest there.

        Args:
            targets: Where to.
            on_begun: Called when the axes have their targets.

        Raises:
            DeviceError: An axis failed; the others have been stopped.
            NodeLostError: There is no contact with an axis; the others have been stopped.
            StopRequested: A stop was requested; the axes have been stopped.
        """
        self._leases.ensure(targets)
        try:
            with self._interruption.attention.needed():
                moving = [axis_id for axis_id in targets if self._begin(axis_id, targets[axis_id])]
                on_begun()
                for axis_id in moving:
                    self._finish(axis_id, targets[axis_id])
                for axis_id, target in targets.items():
                    self._wait_for_target(axis_id, target)
        except BaseException:
            # Whatever went wrong, no axis may keep moving.
            self.stop()
            raise

    def stop(self) -> None:
        """Stop every axis; returns at once."""
        for axis in self._axes.values():
            axis.stop()

    def wait_for_rest(self, limit_s: float) -> Optional[Message]:
        """Wait until no axis moves after `stop`; return what may still move, None if nothing.

        An axis that does not publish is not waited for: its last reading is too old. If it was
        moved here, it is said to move: a driver that died moves nothing, because its motion ends
        without it, but one that is only unreachable looks the same, and people must be careful.
        """
        begun_s, never = self._clock.now_s(), threading.Event()
        while True:
            elapsed_s = self._clock.now_s() - begun_s
            readings = {axis_id: axis.reading() for axis_id, axis in self._axes.items()}
            fresh = {one: r for one, r in readings.items() if _is_younger(r, READING_LIMIT_S)}
            # Only readings well after the request show its effect.
            if elapsed_s > STOP_EFFECT_S and all(
                one is not None and one.age_s < elapsed_s - STOP_EFFECT_S and not one.moving
                for one in fresh.values()
            ):
                silent = [axis_id for axis_id in self._may_move if axis_id not in fresh]
                self._may_move.update({one: False for one in self._may_move if one in fresh})
                return _may_still_move(silent) if silent else None
            if elapsed_s > limit_s:
                return Message("AN AXIS IS STILL MOVING: switch the motors off").with_fault(
                    MAY_MOVE
                )
            self._clock.wait_s(never, POLL_S)

    def _home(self, axis_id: AxisId) -> None:
        parameters = self._parameters[axis_id]
        slow_s = 2.0 * parameters.max_step * parameters.travel_steps
        limit_s = HOMING_TIME_FACTOR * slow_s + TIME_LIMIT_EXTRA_S
        self._may_move[axis_id] = True
        try:
            self._axes[axis_id].home(limit_s)
            self._may_move[axis_id] = False
        except DeviceError as error:
            self._may_move[axis_id] = error.message.may_move
            if isinstance(error, NodeLostError):
                raise
            raise DeviceError(
                Message(
                    "homing the {axis} axis failed: {reason}",
                    axis=axis_id.value,
                    reason=error.message,
                ),
                fault=faults.BLOCKED,
            ) from error

    def _begin(self, axis_id: AxisId, target: float) -> bool:
        # A move of zero length is not sent: actionlib may lose the result of a goal that
        # ends before its sender has returned.
        if self._is_at(axis_id, target):
            return False
        axis = self._axes[axis_id]
        if not self._wait(axis.is_connected, CONNECTION_LIMIT_S):
            raise NodeLostError(
                Message("the {axis} axis driver is not connected", axis=axis_id.value),
                fault=self._lost_fault(axis_id),
            )
        self._may_move[axis_id] = True
        axis.begin_move(target)
        return True

    def _finish(self, axis_id: AxisId, target: float) -> None:
        distance = target - self.reading(axis_id).coordinate
        duration_s = axis_move_duration_s(self._parameters[axis_id], distance)
        limit_s = TIME_LIMIT_FACTOR * duration_s + TIME_LIMIT_EXTRA_S
        deadline_s = self._clock.now_s() + limit_s
        arrived_s: Optional[float] = None
        place = {"axis": axis_id.value, "target": target, "unit": axis_id.unit}
        while True:
            outcome = self._axes[axis_id].move_outcome(POLL_S)
            self._interruption.check()
            if outcome is not None:
                self._may_move[axis_id] = outcome.message.may_move
                break
            now_s = self._clock.now_s()
            if now_s > deadline_s:
                raise DeviceError(
                    Message(
                        "the {axis} axis did not end its move to {target:g} {unit} within "
                        "{limit_s:.0f} s; check its motor and its driver",
                        limit_s=limit_s,
                        **place,
                    ),
                    fault=AXIS_MAY_MOVE,
                )
            if not self._rests_at(axis_id, target):
                arrived_s = None
            elif arrived_s is None:
                arrived_s = now_s
            elif now_s - arrived_s > LOST_RESULT_S:
                self._may_move[axis_id] = False
                return
        if not outcome.success:
            lost = outcome.contact_lost
            raise (NodeLostError if lost else DeviceError)(
                Message(
                    "the {axis} axis did not reach {target:g} {unit}: {reason}",
                    reason=outcome.message,
                    **place,
                ),
                fault=PART_SILENT if lost else faults.BLOCKED,
            )

    def _wait_for_target(self, axis_id: AxisId, target: float) -> None:
        """Wait until the axis reports that it rests at the target."""
        changed = self._axes[axis_id].received
        if self._wait(
            lambda: self.reading(axis_id).homed and self._rests_at(axis_id, target), changed=changed
        ):
            return
        reading = self.reading(axis_id)
        _refuse_not_homed(axis_id, reading)
        raise DeviceError(
            Message(
                "the {axis} axis is at {coordinate:g} {unit} instead of {target:g} {unit}; "
                "stop a paused survey and home the axis; then the survey can be resumed",
                axis=axis_id.value,
                coordinate=reading.coordinate,
                unit=axis_id.unit,
                target=target,
            ),
            fault=faults.BLOCKED,
        )

    def _wait(
        self,
        condition: Callable[[], bool],
        limit_s: float = READING_LIMIT_S,
        changed: Optional[threading.Event] = None,
    ) -> bool:
        """Wait for a condition, at most so long [s]; return whether it is true.

        `changed` is set when it may have become true; None if nothing says so.
        """
        deadline_s = self._clock.now_s() + limit_s
        while True:
            if changed is not None:
                # Before the condition: what happens after it has been checked sets it again.
                changed.clear()
            if condition():
                return True
            if self._clock.now_s() > deadline_s:
                return False
            self._clock.wait_s(changed or self._interruption.stop, POLL_S)
            self._interruption.check()

    def _is_at(self, axis_id: AxisId, target: float) -> bool:
        distance = abs(self.reading(axis_id).coordinate - target)
        return distance < 0.5 * self._parameters[axis_id].step_size

    def _rests_at(self, axis_id: AxisId, target: float) -> bool:
        return not self.reading(axis_id).moving and self._is_at(axis_id, target)


def _may_still_move(axes: List[AxisId]) -> Message:
    return in_a_row(
        Message(
            "the {axis} axis does not answer and may still move: switch the motors off",
            axis=axis_id.value,
        ).with_fault(MAY_MOVE)
        for axis_id in axes
    )


def _refuse_not_homed(axis_id: AxisId, reading: AxisReading) -> None:
    if not reading.homed:
        raise DeviceError(
            Message(
                "the {axis} axis is not homed: its position is unknown; resume the survey to home "
                "it",
                axis=axis_id.value,
            ),
            fault=NOT_HOMED,
        )


def _is_younger(reading: Optional[AxisReading], limit_s: float) -> bool:
    return reading is not None and reading.age_s <= limit_s
