"""Maintenance outside a survey: one action at a time, which a stop ends.

Moves of one axis, and a test of the analyzer: connection, identity, calibration, one sweep.
"""

from __future__ import annotations

import enum
import math
import threading
from dataclasses import dataclass, replace
from typing import Callable, Mapping, Optional, TypeVar

import numpy as np

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, numeral
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, RequestRefusedError, StopRequested
from gpr20_main_control.mid.devices.positioner import Positioner
from gpr20_main_control.mid.devices.robot import Axis, Robot
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import NOT_HOMED, ZERO_UNKNOWN
from gpr20_survey.plan.robot_description import ANALYZER, axis_parameters
from gpr20_survey.radar.frequency_to_delay import decibels
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

# A stopped axis ramps down within this time [s]; one that does not is reported as moving.
REST_LIMIT_S = 10.0
# What is swept if no survey has been planned yet.
TEST_SWEEP = SweepSettings(600.0e6, 6.0e9, 101)
MICRO = 1.0e-6
# Below any analyzer's noise; a level of nothing has no logarithm.
LOWEST_LEVEL = 1.0e-15

Result = TypeVar("Result")


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
        """Begin with no action, with which the axes are stopped.

        `on_change` is called with what is done when one begins, and None when it has ended.
        """
        self.interruption = Interruption(clock)
        self._axes = axes
        self._on_change = on_change
        self._lock = threading.Lock()
        self._activity: Optional[Message] = None

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
    """A request for one axis, and how far a jog goes [mm or deg]."""

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
    """Carries out a request for one axis."""

    def __init__(self, robot: Robot, move: AxisMove, interruption: Interruption) -> None:
        self._move, self._axis_id, self._interruption = move, move.axis, interruption
        self._axis = robot.axes[move.axis]
        self._parameters = axis_parameters(move.axis, robot.description.nodes)
        self._positioner = Positioner(
            robot.axes, {move.axis: self._parameters}, interruption, robot.workers
        )

    def execute(self) -> Message:
        """Carry out the request and return, when the axis is at rest, where it is.

        Raises:
            RequestRefusedError: It is not possible now; nothing moved.
            DeviceError: The axis failed.
            StopRequested: A stop was requested; the axis is at rest.
        """
        try:
            self._interruption.check()
            self._positioner.reserve()
            if self._move.action is AxisAction.HOME:
                self._positioner.home(again=[self._axis_id])
                return Message("The {axis} axis is homed.", axis=self._axis_id.value)
            if self._move.action is AxisAction.SET_ZERO:
                return self._set_zero()
            return self._jog()
        except DeviceError:
            self._positioner.stop()
            raise
        except StopRequested as error:
            self._positioner.stop()
            raise StopRequested(self._stopped()) from error
        finally:
            self._positioner.release()

    def _set_zero(self) -> Message:
        axis = self._axis_id.value
        if self._parameters.finds_zero:
            raise RequestRefusedError(
                Message(
                    "the endstop determines the zero of the {axis} axis; home it instead",
                    axis=axis,
                ),
                fault=NOT_HOMED,
            )
        self._axis.set_zero()
        return Message("The present angle of the {axis} axis is its zero.", axis=axis)

    def _jog(self) -> Message:
        parameters, distance = self._parameters, self._move.distance
        place = {"axis": self._axis_id.value, "unit": self._axis_id.unit}
        reading = self._positioner.reading(self._axis_id)
        if reading.moving:
            raise RequestRefusedError(
                Message("the {axis} axis is already moving; press STOP", axis=place["axis"]),
                fault=faults.AXIS_MOVES,
            )
        if not reading.homed and not parameters.finds_zero:
            raise RequestRefusedError(
                Message(
                    "the angle of the {axis} axis is unknown; home it, or set its zero",
                    axis=place["axis"],
                ),
                fault=ZERO_UNKNOWN,
            )
        if not reading.homed:
            raise RequestRefusedError(
                Message(
                    "the {axis} axis is not homed: its position is unknown; home it, then move it",
                    axis=place["axis"],
                ),
                fault=NOT_HOMED,
            )
        target = jog_target(parameters, reading.coordinate, distance)
        if (target - reading.coordinate) * distance <= 0.0:
            raise RequestRefusedError(
                Message(
                    "the {axis} axis is at {coordinate:.6g} {unit}, the end of its range from "
                    "{low:g} to {high:g} {unit}; move it the other way",
                    coordinate=reading.coordinate,
                    low=parameters.min_coord,
                    high=parameters.max_coord,
                    **place,
                ),
                fault=NOT_ALLOWED,
            )
        self._positioner.move({self._axis_id: target})
        if abs(target - reading.coordinate) < abs(distance) - parameters.step_size:
            return Message(
                "The {axis} axis is at {coordinate:.6g} {unit}, the end of its range.",
                coordinate=target,
                **place,
            )
        return Message("The {axis} axis is at {coordinate:.6g} {unit}.", coordinate=target, **place)

    def _stopped(self) -> Message:
        moving = self._positioner.wait_for_rest(REST_LIMIT_S)
        if moving is not None:
            return moving
        reading, axis = self._axis.reading(), self._axis_id.value
        if reading is None or not reading.homed:
            return Message("stopped; the {axis} axis is not homed", axis=axis).with_fault(
                NOT_HOMED.as_note()
            )
        return Message(
            "stopped; the {axis} axis is at {coordinate:.6g} {unit}",
            axis=axis,
            coordinate=reading.coordinate,
            unit=self._axis_id.unit,
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


def run_analyzer_test(
    robot: Robot, address: str, settings: SweepSettings, interruption: Interruption
) -> AnalyzerTest:
    """Test the analyzer and release it; nothing moves. Return what was found up to a failure."""
    nodes, analyzer = robot.description.nodes, robot.analyzer
    if not address and ANALYZER in nodes:
        address = str(nodes[ANALYZER].configuration.get("address", ""))
    test = AnalyzerTest(address)

    def call(one: Callable[[], Result]) -> Result:
        return robot.analyzer_calls.call(one, interruption.check)

    try:
        test = replace(test, identity=call(lambda: analyzer.connect(address)))
        if robot.description.problem() is None:
            robot.description.check_identity(test.identity, robot.description.config())
        test = replace(test, calibration=call(analyzer.calibration).status.name)
        call(lambda: analyzer.configure(settings))
        unconfirmed = call(analyzer.sweep)
        call(lambda: analyzer.confirm(unconfirmed.number))
        test = _with_sweep(test, unconfirmed.sweep)
    except StopRequested:
        test = replace(test, failure=Message("the test was stopped").with_fault(ASKED_FOR))
    except Gpr20Error as error:
        test = replace(test, failure=error.message)
    # Without waiting: behind a call that hangs it comes late, but before any later call.
    robot.analyzer_calls.begin(analyzer.release)
    return test


def _with_sweep(test: AnalyzerTest, sweep: Sweep) -> AnalyzerTest:
    level = float(np.median(np.hypot(sweep.s21_real, sweep.s21_imag)))
    return replace(
        test,
        points=len(sweep.frequency_hz),
        sweep_duration_s=MICRO * (sweep.sweep_ended_us - sweep.sweep_started_us),
        level_db=float(decibels(level, LOWEST_LEVEL)),
    )
