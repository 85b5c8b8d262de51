"""The three axes moving together."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import partial
from typing import Callable, Dict, List, Mapping, Optional

from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.robot import Axis, AxisId, AxisReading
from gpr20_main_control.mid.serial_calls import in_background, result_of
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.survey_cost import axis_move_duration_s
from gpr20_survey.plan.survey_plan import SurveyPoint

# An axis publishes at 10 Hz at rest; one that was silent for so long is not alive.
SILENCE_LIMIT_S = 2.0
# Nodes that were launched together need so long until the last of them speaks.
START_LIMIT_S = 10.0
# A move may take this many times as long as it should, and some more.
TIME_LIMIT_FACTOR = 1.5
TIME_LIMIT_EXTRA_S = 5.0
# Homing goes the length of the axis at the lowest speed and touches twice.
HOMING_TIME_FACTOR = 1.3
# How often a waiting survey looks whether a stop was requested.
POLL_S = 0.05
# A stop request has reached an axis after so long.
STOP_NEWS_S = 0.2
# An axis that rests at its target for so long has ended its move, whoever lost the result.
LOST_RESULT_S = 1.0


@dataclass(frozen=True)
class Position:
    """Where the axes say that they are: x and y [mm], z [deg]."""

    x_mm: float
    y_mm: float
    z_deg: float


class Positioner:
    """Homes the axes, moves them together, and knows where they are."""

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        parameters: Dict[AxisId, AxisParameters],
        interruption: Interruption,
    ) -> None:
        self._axes = axes
        self._parameters = parameters
        self._interruption = interruption
        self._never = threading.Event()
        self._clock = interruption.clock

    def check_alive(self) -> None:
        """Refuse to go on unless every axis speaks now; one that is starting gets some time.

        What an axis said before may be from a node that has died since, and with it its zero.

        Raises:
            DeviceError: An axis is silent.
            StopRequested: A stop of the survey was requested.
        """
        begun_s = self._clock.now_s()

        def all_speak() -> bool:
            if self._silent():
                return False
            elapsed_s = self._clock.now_s() - begun_s
            return all(self._reading(axis_id).age_s <= elapsed_s for axis_id in self._axes)

        self._wait(all_speak, START_LIMIT_S)
        for axis_id in self._axes:
            self._reading(axis_id)

    def position(self) -> Position:
        """Return where the axes stand.

        Raises:
            DeviceError: An axis is silent or not homed.
        """
        readings = {axis_id: self._reading(axis_id) for axis_id in self._axes}
        for axis_id, reading in readings.items():
            if not reading.homed:
                raise DeviceError(
                    f"the {axis_id.value} axis is not homed: its position is unknown; "
                    "resume the survey to home it"
                )
        return Position(
            readings[AxisId.X].coordinate,
            readings[AxisId.Y].coordinate,
            readings[AxisId.Z].coordinate,
        )

    def home(self, again: bool = False) -> List[AxisId]:
        """Home together every axis that is not homed.

        Args:
            again: Home the others, too.

        Returns:
            The axes that were homed.

        Raises:
            DeviceError: An axis could not be homed.
            NodeLostError: A node is gone; axes may be homing still.
            StopRequested: A stop of the survey was requested.
        """
        pending = [one for one in self._axes if again or not self._reading(one).homed]
        homings = [in_background(partial(self._home, axis_id)) for axis_id in pending]
        failures = []
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
        self._wait(lambda: all(self._reading(axis_id).homed for axis_id in pending))
        return pending

    def move_to(self, point: SurveyPoint) -> None:
        """Move the axes to a point and return when all of them stand there.

        Raises:
            DeviceError: An axis failed; the others have been stopped.
            StopRequested: A stop of the survey was requested; the axes have been stopped.
        """
        targets = {AxisId.X: point.x_mm, AxisId.Y: point.y_mm, AxisId.Z: point.z_deg}
        self.position()
        try:
            moving = [axis_id for axis_id in self._axes if self._begin(axis_id, targets[axis_id])]
            for axis_id in moving:
                self._finish(axis_id, targets[axis_id])
            for axis_id, target in targets.items():
                self._wait_for_target(axis_id, target)
        except BaseException:
            # Whatever went wrong, nothing keeps moving.
            self.stop()
            raise

    def stop(self) -> None:
        """Stop every axis; returns at once."""
        for axis in self._axes.values():
            axis.stop()

    def wait_for_rest(self, limit_s: float) -> bool:
        """Wait until no axis moves any more after `stop`; return whether that was seen.

        An axis that is silent is not waited for: what a dead node last said is no news.
        """
        begun_s = self._clock.now_s()
        while True:
            elapsed_s = self._clock.now_s() - begun_s
            readings = [axis.reading() for axis in self._axes.values()]
            fresh = [one for one in readings if one is not None and _is_fresh(one)]
            # Only what was said well after the request tells of its effect.
            news = elapsed_s > STOP_NEWS_S and all(
                one.age_s < elapsed_s - STOP_NEWS_S for one in fresh
            )
            if news and not any(one.moving for one in fresh):
                return True
            if elapsed_s > limit_s:
                return False
            self._clock.wait_s(self._never, POLL_S)

    def _home(self, axis_id: AxisId) -> None:
        parameters = self._parameters[axis_id]
        slow_s = 2.0 * parameters.max_step * parameters.travel_steps
        limit_s = HOMING_TIME_FACTOR * slow_s + TIME_LIMIT_EXTRA_S
        try:
            self._axes[axis_id].home(limit_s)
        except DeviceError as error:
            raise DeviceError(f"homing the {axis_id.value} axis failed: {error}") from error

    def _begin(self, axis_id: AxisId, target: float) -> bool:
        # A move of no length is not sent: actionlib may lose the result of a goal that
        # ends before its sender has returned.
        if self._at_target(axis_id, self._reading(axis_id), target):
            return False
        self._axes[axis_id].begin_move(target)
        return True

    def _finish(self, axis_id: AxisId, target: float) -> None:
        distance = target - self._reading(axis_id).coordinate
        duration_s = axis_move_duration_s(self._parameters[axis_id], distance)
        limit_s = TIME_LIMIT_FACTOR * duration_s + TIME_LIMIT_EXTRA_S
        deadline_s = self._clock.now_s() + limit_s
        arrived_s: Optional[float] = None
        while True:
            outcome = self._axes[axis_id].move_outcome(POLL_S)
            self._interruption.check()
            if outcome is not None:
                break
            now_s = self._clock.now_s()
            if now_s > deadline_s:
                raise DeviceError(
                    f"the {axis_id.value} axis did not end its move to {target:g} "
                    f"{axis_id.unit} within {limit_s:.0f} s; check its motor and its node"
                )
            reading = self._reading(axis_id)
            if reading.moving or not self._at_target(axis_id, reading, target):
                arrived_s = None
            elif arrived_s is None:
                arrived_s = now_s
            elif now_s - arrived_s > LOST_RESULT_S:
                return
        if not outcome.success:
            raise DeviceError(
                f"the {axis_id.value} axis did not reach {target:g} {axis_id.unit}: "
                f"{outcome.message}"
            )

    def _wait_for_target(self, axis_id: AxisId, target: float) -> None:
        """Wait until the axis itself says that it rests at the target."""

        def arrived() -> bool:
            reading = self._reading(axis_id)
            return (
                reading.homed and not reading.moving and self._at_target(axis_id, reading, target)
            )

        if not self._wait(arrived):
            if not self._reading(axis_id).homed:
                raise DeviceError(
                    f"the {axis_id.value} axis has lost its zero; resume the survey to home it"
                )
            raise DeviceError(
                f"the {axis_id.value} axis stands at {self._reading(axis_id).coordinate:g} "
                f"{axis_id.unit} instead of {target:g} {axis_id.unit}; home it"
            )

    def _wait(self, condition: Callable[[], bool], limit_s: float = SILENCE_LIMIT_S) -> bool:
        deadline_s = self._clock.now_s() + limit_s
        while not condition():
            if self._clock.now_s() > deadline_s:
                return False
            self._interruption.wait_s(POLL_S)
        return True

    def _at_target(self, axis_id: AxisId, reading: AxisReading, target: float) -> bool:
        return abs(reading.coordinate - target) < 0.5 * self._parameters[axis_id].step_size

    def _silent(self) -> List[AxisId]:
        readings = {axis_id: axis.reading() for axis_id, axis in self._axes.items()}
        return [axis_id for axis_id, reading in readings.items() if not _is_fresh(reading)]

    def _reading(self, axis_id: AxisId) -> AxisReading:
        reading = self._axes[axis_id].reading()
        if reading is None or not _is_fresh(reading):
            raise DeviceError(
                f"the {axis_id.value} axis is silent: nothing on {axis_id.value}_axis/"
                f"current_coord for {SILENCE_LIMIT_S:g} s; check that its node runs"
            )
        return reading


def _is_fresh(reading: Optional[AxisReading]) -> bool:
    return reading is not None and reading.age_s <= SILENCE_LIMIT_S
