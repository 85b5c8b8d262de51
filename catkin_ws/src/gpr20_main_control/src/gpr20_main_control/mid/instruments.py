"""The analyzer and the height sensor during one survey: their checks and one trace."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.clock_steps import ClockSteps
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.robot import Position, Robot
from gpr20_main_control.mid.serial_calls import in_background, result_of
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.plan.survey_plan import SurveyPoint
from gpr20_survey.plan.survey_settings import HeightPolicy
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep, storable_remark
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class AnalyzerState:
    """What is known about the analyzer before a survey."""

    identity: str
    calibration: CalibrationStatus
    settings: SweepSettings


class Instruments:
    """Checks the instruments of one survey, and measures at the present position."""

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        positioner: Positioner,
        interruption: Interruption,
        clock_steps: ClockSteps,
    ) -> None:
        self._clock_steps = clock_steps
        self._plan = plan
        self._robot = robot
        self._positioner = positioner
        self._interruption = interruption
        # On a robot that runs N times faster, vibrations decay N times faster.
        self._settle_s = plan.settings.settle_s / plan.config.time_scale
        self._frequencies_hz = np.empty(0) if plan.last is None else plan.last.frequency_hz

    def check(self) -> AnalyzerState:
        """Check everything that the survey needs, and return the state of the analyzer.

        Nothing moves.

        Raises:
            DeviceError: A check failed.
        """
        self._positioner.check_alive()
        self._robot.description.check(self._plan.config)
        analyzer = self._check_analyzer()
        if self._plan.settings.on_height_failure == HeightPolicy.PAUSE.value:
            height_call = in_background(self._robot.height_sensor.height_m)
            result_of(height_call, self._interruption.check)
        return analyzer

    def measure(self, point: SurveyPoint) -> Trace:
        """Measure one point; the axes must be there.

        Raises:
            DeviceError: A part failed, or the axes moved during the sweep.
            NodeLostError: A node does not answer or was restarted.
            StopRequested: A stop of the survey was requested.
        """
        try:
            return self._measure(point)
        except TraceRefusedError as error:
            # The operator can remove the cause, such as a wrong clock: the survey pauses.
            raise DeviceError(error.message) from error

    def _measure(self, point: SurveyPoint) -> Trace:
        self._interruption.wait_s(self._settle_s)
        self._robot.description.check(self._plan.config)
        before = self._positioner.position()
        _check_position(point, before)
        sweep, height_m, remarks = self._sweep_and_height()
        self._interruption.check()
        if self._positioner.position() != before:
            raise DeviceError(
                Message(
                    "the axes moved during the sweep at point {index}; nothing else may move them "
                    "during a survey",
                    index=point.index,
                )
            )
        self._check_sweep(sweep)
        timestamp_us = time_of_day_us()
        clock_step = self._clock_steps.check_trace(timestamp_us)
        if clock_step is not None:
            remarks += (storable_remark(str(clock_step)),)
        measured = {**vars(sweep), "quality": sweep.quality + remarks}
        return Trace(
            **measured,
            survey_id=self._plan.survey_id,
            sample_id=str(uuid.uuid4()),
            index=point.index,
            timestamp_us=timestamp_us,
            x_coord_mm=before.x_mm,
            y_coord_mm=before.y_mm,
            z_coord_deg=before.z_deg,
            antennae_height_m=height_m,
        )

    def _check_analyzer(self) -> AnalyzerState:
        analyzer, calls = self._robot.analyzer, self._robot.analyzer_calls
        check = self._interruption.check
        wanted = self._plan.parameters.sweep_settings
        identity = calls.call(lambda: analyzer.connect(self._plan.parameters.vna_address), check)
        self._robot.description.check_identity(identity, self._plan.config)
        calibration = calls.call(analyzer.calibration, check)
        accepted = calls.call(lambda: analyzer.configure(wanted), check)
        if not accepted.fulfils(wanted):
            raise DeviceError(
                Message(
                    "the VNA accepted {accepted} instead of {wanted}",
                    accepted=_sweep_message(accepted),
                    wanted=_sweep_message(wanted),
                )
            )
        frequencies_hz = calls.call(analyzer.frequencies_hz, check)
        if len(self._frequencies_hz) and not np.array_equal(frequencies_hz, self._frequencies_hz):
            raise DeviceError(
                Message(
                    "the VNA's frequencies are no longer those of this survey; stop the survey and "
                    "start a new one"
                )
            )
        self._frequencies_hz = frequencies_hz
        return AnalyzerState(identity, calibration, accepted)

    def _sweep_and_height(self) -> Tuple[Sweep, float, Tuple[str, ...]]:
        height_call = in_background(self._height)
        sweep_call = in_background(self._robot.analyzer.sweep)
        sweep = result_of(sweep_call, self._interruption.check)
        height_m, remarks = result_of(height_call, self._interruption.check)
        return sweep, height_m, remarks

    def _height(self) -> Tuple[float, Tuple[str, ...]]:
        failure: Optional[DeviceError] = None
        for _attempt in range(self._plan.settings.attempts):
            try:
                return self._robot.height_sensor.height_m(), ()
            except DeviceError as error:
                failure = error
        assert failure is not None
        if self._plan.settings.on_height_failure == HeightPolicy.STORE_WITHOUT.value:
            return float("nan"), (storable_remark(f"no height: {failure}"),)
        raise DeviceError(
            Message("the antenna height could not be measured: {reason}", reason=failure.message)
        ) from failure

    def _check_sweep(self, sweep: Sweep) -> None:
        frequency_hz = sweep.frequency_hz
        if not np.array_equal(frequency_hz, self._frequencies_hz):
            first_hz, last_hz = float(frequency_hz[0]), float(frequency_hz[-1])
            measured = SweepSettings(first_hz, last_hz, len(frequency_hz))
            raise DeviceError(
                Message(
                    "the VNA measured {measured} instead of {wanted}; do not change its settings "
                    "during a survey",
                    measured=_sweep_message(measured),
                    wanted=_sweep_message(self._plan.parameters.sweep_settings),
                )
            )


def _check_position(point: SurveyPoint, position: Position) -> None:
    planned = Position(point.x_mm, point.y_mm, point.z_deg)
    if position != planned:
        raise DeviceError(
            Message(
                "the axes are at {position} instead of {planned} before the sweep at point "
                "{index}; nothing else may move them during a survey",
                position=position.message,
                planned=planned.message,
                index=point.index,
            )
        )


def _sweep_message(settings: SweepSettings) -> Message:
    return Message(
        "{points} points from {start_mhz:.12g} to {stop_mhz:.12g} MHz",
        points=settings.points,
        start_mhz=1.0e-6 * settings.start_frequency_hz,
        stop_mhz=1.0e-6 * settings.stop_frequency_hz,
    )
