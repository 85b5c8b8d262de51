"""Maintenance outside a survey: one action at a time, which a stop ends; moves of one axis."""

from __future__ import annotations

import enum
import math
import threading
from dataclasses import dataclass
from typing import Callable, Mapping, Optional

from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, numeral
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, RequestRefusedError, StopRequested
from gpr20_main_control.mid.devices.axis_leases import AxisLeases
from gpr20_main_control.mid.devices.positioner import Positioner
from gpr20_main_control.mid.devices.robot import Axis, Robot
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import NOT_HOMED, ZERO_UNKNOWN
from gpr20_survey.plan.robot_description import axis_parameters

# A stopped axis ramps down within this time [s]; one that does not is reported as moving.
REST_LIMIT_S = 10.0


class ServiceSlot:
    """Holds the action that is in progress; every method may be called from any thread.

    Attributes:
        interruption: What ends the waits of the action.
    """

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        clock: Clock,
        on_change: Callable[[Optional[Message]], None],
    ) -> None:
        """Begin with no action.

        Args:
            axes: Stopped with the action.
            clock: The clock of every wait.
            on_change: Called with what is done when an action begins, and None when it has ended.
        """
        self.interruption = Interruption(clock)
        self._axes = axes
        self._on_change = on_change
        self._lock = threading.Lock()
        self._activity: Optional[Message] = None

    @property
    def activity(self) -> Optional[Message]:
        """What is done now; None: nothing."""
        return self._activity

    def claim(self, activity: Message) -> None:
        """Begin an action; `release` ends it.

        Raises:
            RequestRefusedError: Another one is in progress.
        """
        with self._lock:
            self.refuse_while_busy()
            self.interruption.stop.clear()
            self._activity = activity
        self._on_change(activity)

    def release(self) -> None:
        """End the action; the axes are at rest."""
        with self._lock:
            self._activity = None
        self._on_change(None)

    def refuse_while_busy(self) -> None:
        """Return if no action is in progress.

        Raises:
            RequestRefusedError: One is.
        """
        if self._activity is not None:
            raise RequestRefusedError(
                Message(
                    "the robot is in service ({activity}); wait for its end, or press STOP",
                    activity=self._activity,
                ),
                fault=IN_USE,
            )

    def stop(self) -> bool:
        """Stop the action at once; return whether there was one."""
        # No lock: a stop does not wait. It comes after the last claim or is for nothing.
        if self._activity is None:
            return False
        self.interruption.stop.set()
        for axis in self._axes.values():
            axis.stop()
        return True

    def shut_down(self) -> None:
        """End the action, because the main control ends."""
        self.interruption.shut_down()
        self.stop()


class AxisAction(enum.IntEnum):
    """What an axis does; the values are those of gpr20_msgs/ServiceMove."""

    HOME = 0
    JOG = 1
    SET_ZERO = 2


@dataclass(frozen=True)
class AxisMove:
    """A request for one axis.

    Attributes:
        axis: Which axis.
        action: What it does.
        distance: How far a jog goes [mm or deg].
    """

    axis: AxisId
    action: AxisAction
    distance: float = 0.0

    def __post_init__(self) -> None:
        if self.action is AxisAction.JOG and not (math.isfinite(self.distance) and self.distance):
            raise RequestRefusedError(
                Message(
                    "the distance is {distance}; it must be a number other than 0",
                    distance=numeral(self.distance),
                ),
                fault=NOT_ALLOWED,
            )

    @property
    def activity(self) -> Message:
        """What is being done."""
        if self.action is AxisAction.HOME:
            return Message("homing the {axis} axis", axis=self.axis.value)
        if self.action is AxisAction.SET_ZERO:
            return Message("setting the zero of the {axis} axis", axis=self.axis.value)
        return Message(
            "moving the {axis} axis by {distance:+.6g} {unit}",
            axis=self.axis.value,
            distance=self.distance,
            unit=self.axis.unit,
        )


def axis_move(axis: str, action: int, distance: float) -> AxisMove:
    """Return the request with these values.

    Raises:
        RequestRefusedError: They are not allowed.
    """
    axes, actions = [one.value for one in AxisId], [int(one) for one in AxisAction]
    if axis not in axes:
        raise RequestRefusedError(
            Message("the axis is {axis}; it must be x, y or z", axis=repr(axis[:16])),
            fault=NOT_ALLOWED,
        )
    if action not in actions:
        raise RequestRefusedError(
            Message("the action is {action}; it must be 0, 1 or 2", action=action),
            fault=NOT_ALLOWED,
        )
    return AxisMove(AxisId(axis), AxisAction(action), distance)


class AxisService:
    """Carries out the requests for one axis at a time."""

    def __init__(self, robot: Robot, interruption: Interruption) -> None:
        self._robot = robot
        self._interruption = interruption

    def execute(self, move: AxisMove) -> Message:
        """Carry out a request and return, when the axis is at rest, where it is.

        Raises:
            RequestRefusedError: It is not possible now; nothing moved.
            DeviceError: The axis failed.
            StopRequested: A stop was requested; the axis is at rest.
        """
        parameters = axis_parameters(move.axis, self._robot.description.nodes)
        axes = {move.axis: self._robot.axes[move.axis]}
        leases = AxisLeases(self._robot.axes, self._interruption.attention)
        positioner = Positioner(
            axes, {move.axis: parameters}, self._interruption, self._robot.workers, leases
        )
        try:
            self._interruption.check()
            leases.ensure(axes)
            if move.action is AxisAction.HOME:
                positioner.home(again=axes)
                return Message("The {axis} axis is homed.", axis=move.axis.value)
            if move.action is AxisAction.SET_ZERO:
                return self._set_zero(move.axis, parameters)
            return self._jog(move, parameters, positioner)
        except DeviceError:
            positioner.stop()
            raise
        except StopRequested as error:
            positioner.stop()
            raise StopRequested(self._stopped(move.axis, positioner)) from error
        finally:
            leases.release()

    def _set_zero(self, axis_id: AxisId, parameters: AxisParameters) -> Message:
        if parameters.finds_zero:
            raise RequestRefusedError(
                Message(
                    "the endstop determines the zero of the {axis} axis; home it instead",
                    axis=axis_id.value,
                ),
                fault=NOT_HOMED,
            )
        self._robot.axes[axis_id].set_zero()
        return Message("The present angle of the {axis} axis is its zero.", axis=axis_id.value)

    def _jog(self, move: AxisMove, parameters: AxisParameters, positioner: Positioner) -> Message:
        reading = positioner.reading(move.axis)
        if reading.moving:
            raise RequestRefusedError(
                Message("the {axis} axis is already moving; press STOP", axis=move.axis.value),
                fault=faults.AXIS_MOVES,
            )
        if not reading.homed:
            raise RequestRefusedError(_not_homed(move.axis, parameters))
        target = jog_target(parameters, reading.coordinate, move.distance)
        place = {"axis": move.axis.value, "unit": move.axis.unit}
        ends = {"low": parameters.min_coord, "high": parameters.max_coord}
        if (target - reading.coordinate) * move.distance <= 0.0:
            raise RequestRefusedError(
                Message(
                    "the {axis} axis is at {coordinate:.6g} {unit}, the end of its range from "
                    "{low:g} to {high:g} {unit}; move it the other way",
                    coordinate=reading.coordinate,
                    **place,
                    **ends,
                ),
                fault=NOT_ALLOWED,
            )
        positioner.move_axis(move.axis, target)
        if abs(target - reading.coordinate) < abs(move.distance) - parameters.step_size:
            return Message(
                "The {axis} axis is at {coordinate:.6g} {unit}, the end of its range.",
                coordinate=target,
                **place,
            )
        return Message("The {axis} axis is at {coordinate:.6g} {unit}.", coordinate=target, **place)

    def _stopped(self, axis_id: AxisId, positioner: Positioner) -> Message:
        moving = positioner.wait_for_rest(REST_LIMIT_S)
        if moving is not None:
            return moving
        reading = self._robot.axes[axis_id].reading()
        if reading is None or not reading.homed:
            return Message("stopped; the {axis} axis is not homed", axis=axis_id.value).with_fault(
                NOT_HOMED.as_note()
            )
        return Message(
            "stopped; the {axis} axis is at {coordinate:.6g} {unit}",
            axis=axis_id.value,
            coordinate=reading.coordinate,
            unit=axis_id.unit,
        ).with_fault(ASKED_FOR)


def jog_target(parameters: AxisParameters, coordinate: float, distance: float) -> float:
    """Return where a jog ends: on a motor step, at least one away, within the axis [mm or deg]."""
    low, high = parameters.min_coord, parameters.max_coord
    lowest, highest = parameters.distance_steps(low), parameters.distance_steps(high)
    # An end that is no motor step is not reached.
    lowest += parameters.coordinate_of(lowest) < low
    highest -= parameters.coordinate_of(highest) > high
    # No farther than the whole axis: the steps of a huge distance need not be counted.
    length = high - low
    change = parameters.distance_steps(max(-length, min(length, distance)))
    steps = parameters.distance_steps(coordinate) + (change or int(math.copysign(1, distance)))
    return parameters.coordinate_of(max(lowest, min(highest, steps)))


def _not_homed(axis_id: AxisId, parameters: AxisParameters) -> Message:
    if not parameters.finds_zero:
        return Message(
            "the angle of the {axis} axis is unknown; home it, or set its zero", axis=axis_id.value
        ).with_fault(ZERO_UNKNOWN)
    return Message(
        "the {axis} axis is not homed: its position is unknown; home it, then move it",
        axis=axis_id.value,
    ).with_fault(NOT_HOMED)
