"""One point of a survey: move there, settle, sweep and measure the height."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.background import in_background, result_of
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Position, Positioner
from gpr20_main_control.mid.preparation import Preparation
from gpr20_main_control.mid.robot import Robot
from gpr20_survey.plan.survey_plan import SurveyPoint
from gpr20_survey.plan.survey_settings import HeightPolicy, SurveySettings
from gpr20_survey.trace.sweep import Sweep

LONGEST_REMARK = 200


@dataclass(frozen=True)
class Measured:
    """What was measured at one point.

    Attributes:
        position: Where the axes said that they stood, before and after the sweep.
        sweep: The sweep.
        height_m: Height of the antennas [m]; NaN if it was not measured.
        remarks: Remarks on the quality, the sweep's included.
    """

    position: Position
    sweep: Sweep
    height_m: float
    remarks: Tuple[str, ...]


class PointMeasurement:
    """Measures points one after another."""

    def __init__(
        self,
        robot: Robot,
        positioner: Positioner,
        preparation: Preparation,
        settings: SurveySettings,
        interruption: Interruption,
        clock: Clock,
    ) -> None:
        self._robot = robot
        self._positioner = positioner
        self._preparation = preparation
        self._settings = settings
        self._interruption = interruption
        self._clock = clock

    def measure(self, point: SurveyPoint) -> Measured:
        """Measure one point.

        Raises:
            DeviceError: A part failed, or the axes moved during the sweep.
            NodeLostError: A node is gone, or is another than before.
            StopRequested: The survey was told to stop.
        """
        self._interruption.check()
        self._positioner.move_to(point)
        self._clock.wait_s(self._interruption.stop, self._settings.settle_s)
        self._interruption.check()
        before = self._positioner.position()
        self._check_position(point, before)
        sweep, height_m, remarks = self._sweep_and_height()
        self._interruption.check()
        if self._positioner.position() != before:
            raise DeviceError(
                f"the axes moved during the sweep at point {point.index}; nobody else may move "
                "them during a survey"
            )
        self._preparation.check_sweep(sweep)
        return Measured(before, sweep, height_m, sweep.quality + remarks)

    def _check_position(self, point: SurveyPoint, position: Position) -> None:
        planned = Position(point.x_mm, point.y_mm, point.z_deg)
        if position != planned:
            raise DeviceError(
                f"the axes stand at {position} instead of {planned} before the sweep at point "
                f"{point.index}; nobody else may move them during a survey"
            )

    def _sweep_and_height(self) -> Tuple[Sweep, float, Tuple[str, ...]]:
        height_call = in_background(self._height)
        sweep_call = in_background(self._robot.analyzer.sweep)
        sweep = result_of(sweep_call, self._interruption.check)
        height_m, remarks = result_of(height_call, self._interruption.check)
        return sweep, height_m, remarks

    def _height(self) -> Tuple[float, Tuple[str, ...]]:
        failure: Optional[DeviceError] = None
        for _attempt in range(self._settings.attempts):
            try:
                return self._robot.height_sensor.height_m(), ()
            except DeviceError as error:
                failure = error
        assert failure is not None
        if self._settings.on_height_failure == HeightPolicy.STORE_WITHOUT.value:
            return float("nan"), (f"no height: {failure}"[:LONGEST_REMARK],)
        raise DeviceError(f"the antenna height could not be measured: {failure}") from failure
