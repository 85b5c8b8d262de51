"""Maintenance outside a survey, which a stop ends.

Moves of one axis, and a test of the analyzer: connection, identity, calibration, one sweep.
"""

from __future__ import annotations

import contextlib
import enum
import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Iterator

import numpy as np

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, NOT_ALLOWED
from gpr20_common.message import Message, numeral
from gpr20_main_control.errors import DeviceError, RequestRefusedError, StopRequested
from gpr20_main_control.mid.devices.positioner import Positioner
from gpr20_main_control.mid.devices.robot import Analyzer, Robot
from gpr20_main_control.mid.waits import REST_LIMIT_S, Interruption
from gpr20_survey.axes import AxisId, AxisParameters
from gpr20_survey.plan.robot_description import axis_parameters
from gpr20_survey.radar import decibels
from gpr20_survey.results.answers import AnalyzerTest
from gpr20_survey.trace.sweep import Sweep, SweepSettings

# What is swept if no survey has been planned yet.
TEST_SWEEP = SweepSettings(600.0e6, 6.0e9, 101)

# Makes a call to the analyzer and returns its result.
Call = Callable[[Callable[[], Any]], Any]


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
    """Return the request with these values, or refuse what is not allowed."""
    known = axis in [one.value for one in AxisId] and action in list(AxisAction)
    if not known or (action == AxisAction.JOG and not (math.isfinite(distance) and distance)):
        raise RequestRefusedError(
            Message(
                "axis {axis}, action {action} and distance {distance} are no move: the axis must "
                "be x, y or z, the action 0, 1 or 2, and the distance of a jog not 0",
                axis=repr(axis[:16]),
                action=action,
                distance=numeral(distance),
            ),
            fault=NOT_ALLOWED,
        )
    return AxisMove(AxisId(axis), AxisAction(action), distance)


def move_axis(robot: Robot, move: AxisMove, interruption: Interruption) -> Message:
    """Carry out a request for one axis and return, when it is at rest, where it is."""
    axis_id, names = move.axis, {"axis": move.axis.value, "unit": move.axis.unit}
    parameters = axis_parameters(axis_id, robot.description.nodes)
    positioner = Positioner(robot.axes, {axis_id: parameters}, interruption, robot.workers)
    try:
        interruption.check()
        positioner.reserve()
        if move.action is AxisAction.HOME:
            positioner.home(again=[axis_id])
            return Message("The {axis} axis is homed.", axis=axis_id.value)
        if move.action is AxisAction.SET_ZERO:
            robot.axes[axis_id].set_zero()
            axis = axis_id.value
            return Message("The present angle of the {axis} axis is its zero.", axis=axis)
        present = positioner.reading(axis_id).coordinate
        target = jog_target(parameters, present, move.distance)
        positioner.move({axis_id: target})
        return Message("The {axis} axis is at {coordinate:.6g} {unit}.", coordinate=target, **names)
    except DeviceError:
        positioner.stop()
        raise
    except StopRequested as error:
        positioner.stop()
        moving = positioner.wait_for_rest(REST_LIMIT_S)
        stopped = Message("the {axis} axis was stopped", axis=axis_id.value)
        raise StopRequested(moving or stopped.with_fault(ASKED_FOR)) from error
    finally:
        positioner.release()


def jog_target(parameters: AxisParameters, coordinate: float, distance: float) -> float:
    """Return the motor step where a jog ends, within the axis [mm or deg]."""
    wanted = max(parameters.min_coord, min(parameters.max_coord, coordinate + distance))
    steps = parameters.distance_steps(wanted)
    # An end that is no motor step is not reached.
    steps -= parameters.coordinate_of(steps) > parameters.max_coord
    steps += parameters.coordinate_of(steps) < parameters.min_coord
    return parameters.coordinate_of(steps)


@contextlib.contextmanager
def analyzer_in_service(robot: Robot, interruption: Interruption) -> Iterator[Call]:
    """Yield what makes a call to the analyzer, which a stop ends; release it afterwards."""
    try:
        yield lambda call: robot.analyzer_calls.call(call, interruption.check)
    except StopRequested as error:
        raise StopRequested(Message("the test was stopped"), fault=ASKED_FOR) from error
    finally:
        # Without waiting: behind a call that hangs it comes late, but before any later call.
        robot.analyzer_calls.begin(robot.analyzer.release)


def confirmed_sweep(analyzer: Analyzer, call: Call) -> Sweep:
    """Return a sweep whose settings the analyzer confirmed."""
    unconfirmed = call(analyzer.sweep)
    call(lambda: analyzer.confirm(unconfirmed.number))
    return unconfirmed.sweep


def run_analyzer_test(
    robot: Robot, address: str, settings: SweepSettings, interruption: Interruption
) -> AnalyzerTest:
    """Test the analyzer and release it; nothing moves. Return what was found up to a failure."""
    analyzer, address = robot.analyzer, address or robot.description.analyzer_address()
    test = AnalyzerTest(address)
    try:
        with analyzer_in_service(robot, interruption) as call:
            test = replace(test, identity=call(lambda: analyzer.connect(address)))
            if robot.description.problem is None:
                robot.description.check_identity(test.identity, robot.description.config())
            test = replace(test, calibration=call(analyzer.calibration).status.name)
            call(lambda: analyzer.configure(settings))
            sweep = confirmed_sweep(analyzer, call)
            test = replace(
                test,
                points=len(sweep.frequency_hz),
                sweep_duration_s=1e-6 * (sweep.sweep_ended_us - sweep.sweep_started_us),
                level_db=float(decibels(np.median(np.hypot(sweep.s21_real, sweep.s21_imag)))),
            )
    except Gpr20Error as error:
        test = replace(test, failure=error.message)
    return test
