"""The three axes moving together."""

from __future__ import annotations

import threading
from typing import Callable, Collection, Dict, List, Mapping, Optional

from gpr20_common.faults import MAY_MOVE, PART_LOST, PART_SILENT
from gpr20_common.message import Fault, Message, in_a_row
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.devices.axis_motion import (
    CONNECTION_LIMIT_S,
    POLL_S,
    READING_LIMIT_S,
    AxisMotion,
    LeaseKeeper,
    wait_until,
)
from gpr20_main_control.mid.devices.robot import Axis, AxisReading, Position, zeros_of
from gpr20_main_control.mid.waits import Interruption, Workers, result_of
from gpr20_survey.axes.axis_id import AxisId, ZeroEpoch
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.survey_points import SurveyPoint

# A stop request reaches an axis within this time [s].
STOP_EFFECT_S = 0.2


class Positioner:
    """Reserves all axes; homes those that are used, moves them together, knows their position."""

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        parameters: Mapping[AxisId, AxisParameters],
        interruption: Interruption,
        workers: Workers,
    ) -> None:
        """Reserve nothing yet; the axes with `parameters` are used."""
        attention = interruption.attention
        self._leases = {axis_id: LeaseKeeper(axis, attention) for axis_id, axis in axes.items()}
        self._axes = {
            axis_id: AxisMotion(axis_id, axes[axis_id], own, interruption)
            for axis_id, own in parameters.items()
        }
        self._interruption, self._clock = interruption, interruption.clock
        self._workers = workers

    def reserve(self) -> None:
        """Return when the axes are reserved.

        Raises:
            DeviceError: Another node has an axis, whether it is used or not.
            NodeLostError: An axis that is used does not answer.
        """
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

        An older reading may be from a node that has died since, and lost its zero with it.

        Raises:
            DeviceError: An axis does not publish.
            StopRequested: A stop of the survey was requested.
        """
        begun_s = self._clock.now_s()

        def all_publish() -> bool:
            limit_s = min(self._clock.now_s() - begun_s, READING_LIMIT_S)
            return all(axis.fresh_reading(limit_s) is not None for axis in self._axes.values())

        wait_until(all_publish, CONNECTION_LIMIT_S, self._interruption)
        self.reserve()
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
        return self._axes[axis_id].reading()

    @property
    def lost_fault(self) -> Fault:
        """What a lost part means: until every axis rests, that hands have to stay clear."""
        return PART_LOST if any(axis.may_move for axis in self._axes.values()) else PART_SILENT

    def position(self) -> Position:
        """Return the position of the axes.

        Raises:
            NodeLostError: An axis does not publish.
            DeviceError: An axis is not homed.
        """
        readings = {axis_id: axis.homed_reading() for axis_id, axis in self._axes.items()}
        x_mm, y_mm, z_deg = (readings[axis_id].coordinate for axis_id in AxisId)
        zeros = zeros_of({axis_id: reading.zero for axis_id, reading in readings.items()})
        return Position(x_mm, y_mm, z_deg, zeros)

    def zeros(self) -> Dict[AxisId, ZeroEpoch]:
        """Return the zero of each axis, or the last one of an axis that is not homed.

        Raises:
            NodeLostError: An axis does not publish.
        """
        return {axis_id: axis.reading().zero for axis_id, axis in self._axes.items()}

    def home(self, again: Collection[AxisId] = ()) -> List[AxisId]:
        """Home together every axis that is not homed, or is to be homed again; return which.

        Raises:
            DeviceError: An axis could not be homed.
            NodeLostError: A node is lost; axes may still be homing.
            StopRequested: A stop of the survey was requested.
        """
        self.reserve()
        pending = [
            axis
            for axis_id, axis in self._axes.items()
            if axis_id in again or not axis.reading().homed
        ]
        failures = []
        with self._interruption.attention.needed():
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
        wait_until(
            lambda: all(axis.reading().homed for axis in pending),
            READING_LIMIT_S,
            self._interruption,
        )
        return [axis.axis_id for axis in pending]

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
        self.reserve()
        try:
            with self._interruption.attention.needed():
                for axis_id, target in targets.items():
                    self._axes[axis_id].begin(target)
                on_begun()
                for axis_id, target in targets.items():
                    self._axes[axis_id].finish(target)
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
        moved = [axis for axis in self._axes.values() if axis.may_move is not None]
        for axis in moved:
            axis.may_move = axis.may_move and readings[axis] is None
        silent = [axis for axis in moved if readings[axis] is None]
        if not silent:
            return None
        return in_a_row(
            Message(
                "the {axis} axis does not answer and may still move: switch the motors off",
                axis=axis.axis_id.value,
            ).with_fault(MAY_MOVE)
            for axis in silent
        )
