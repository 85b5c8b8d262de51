"""The analyzer and the height sensor of one survey: their checks, and what to expect of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Callable, Mapping, Optional, Tuple, TypeVar

import numpy as np

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import SETUP_LIMIT_S, AnalyzerSetup
from gpr20_main_control.mid.waits import ExpectedWait
from gpr20_survey.faults import NO_GROUND, VNA_SETTINGS
from gpr20_survey.plan.robot_description import HEIGHT_SENSOR, PLAIN_NAMES
from gpr20_survey.plan.survey_parameters import HeightPolicy
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep, storable_remark
from gpr20_survey.trace.sweep_settings import SweepSettings

if TYPE_CHECKING:  # the survey has these instruments
    from gpr20_main_control.mid.survey.survey import Survey

Result = TypeVar("Result")
THE_ANALYZER = Message("the VNA")


@dataclass(frozen=True)
class AnalyzerState:
    """What is known about the analyzer before a survey.

    Attributes:
        identity: What the instrument says it is.
        calibration: The state of its calibration.
        calibration_details: What else it says of its calibration; its temperature among it.
        settings: As read back from it.
        sweep_duration_s: How long one trace takes [s]; measured each time, so that two states of
            the same analyzer are equal without it.
    """

    identity: str
    calibration: CalibrationStatus
    settings: SweepSettings
    sweep_duration_s: float = field(compare=False)
    calibration_details: Mapping[str, Any] = field(compare=False, default_factory=dict)


class Instruments:
    """Checks the instruments of one survey, and knows what to expect of them."""

    def __init__(self, survey: Survey) -> None:
        self._survey = survey
        self._plan, self._robot = survey.plan, survey.robot
        self._waits = survey.waits
        self._wanted = survey.plan.sweep_settings
        self._setup: Optional[AnalyzerSetup] = None
        last = survey.plan.last
        # To the last bit those of every stored trace.
        self._frequencies_hz = self._wanted.frequencies_hz() if last is None else last.frequency_hz

    def check(self, next_index: int) -> AnalyzerState:
        """Check all that is needed to measure a point next; return the state of the analyzer.

        Nothing moves. A DeviceError says which check failed.
        """
        self._survey.positioner.check_alive()
        self._robot.description.check(self._plan.config)
        analyzer = self._check_analyzer(next_index)
        if self._plan.settings.on_height_failure is HeightPolicy.PAUSE:
            self._robot.workers.call(self.height, self._survey.interruption.check)
        self._robot.sensors.check_required()
        return analyzer

    def height(self) -> Tuple[float, Tuple[str, ...]]:
        """Return the height [m], and remarks on it; NaN if the survey may do without.

        Raises:
            DeviceError: It could not be measured.
        """
        failure: Optional[DeviceError] = None
        for _attempt in range(self._plan.settings.attempts):
            try:
                return self._robot.height_m(), ()
            except DeviceError as error:
                failure = error
        assert failure is not None
        if self._plan.settings.on_height_failure is HeightPolicy.STORE_WITHOUT:
            return float("nan"), (storable_remark(f"no height: {failure}"),)
        raise DeviceError(
            Message("the antenna height could not be measured: {reason}", reason=failure.message),
            fault=NO_GROUND,
        ) from failure

    def height_wait(self, point: SurveyPoint) -> ExpectedWait:
        """Return what to expect of a height measurement."""
        limits, attempts = self._robot.description.limits, self._plan.settings.attempts
        action = Message("height at point {index}", index=point.index)
        limit_s = attempts * limits.height_limit_s
        return ExpectedWait(PLAIN_NAMES[HEIGHT_SENSOR], action, 0.0, limit_s)

    def sweep_wait(self, point: SurveyPoint) -> ExpectedWait:
        """Return what to expect of the sweep at a point."""
        assert self._setup is not None
        action = Message("sweep at point {index}", index=point.index)
        expected_s, limit_s = self._setup.sweep_duration_s, self._setup.request_limit_s
        return ExpectedWait(THE_ANALYZER, action, expected_s, limit_s)

    def confirmation_wait(self, point: SurveyPoint) -> ExpectedWait:
        """Return what to expect of the confirmation of a sweep."""
        assert self._setup is not None
        action = Message("settings after the sweep at point {index}", index=point.index)
        return ExpectedWait(THE_ANALYZER, action, 0.0, self._setup.request_limit_s)

    def check_sweep(self, sweep: Sweep) -> None:
        """Refuse a sweep of other frequencies, or with other settings, than those of the survey.

        Raises:
            DeviceError: It has others.
        """
        hz = sweep.frequency_hz
        if not np.array_equal(hz, self._frequencies_hz):
            raise _other_settings(
                _sweep_in_words(SweepSettings(float(hz[0]), float(hz[-1]), len(hz))),
                _sweep_in_words(self._wanted),
            )
        if not sweep.analyzer.fulfils(self._wanted.analyzer):
            raise _other_settings(sweep.analyzer.message, self._wanted.analyzer.message)

    def _check_analyzer(self, next_index: int) -> AnalyzerState:
        analyzer, wanted = self._robot.analyzer, self._wanted
        address = self._plan.parameters.vna_address
        identity = self._call(lambda: analyzer.connect(address), Message("connection"))
        self._robot.description.check_identity(identity, self._plan.config)
        self._survey.analyzers.check(identity, next_index, self._survey.clock.time_of_day_us())
        setup = self._call(
            lambda: analyzer.configure(wanted), Message("setup of the sweep"), SETUP_LIMIT_S
        )
        accepted = setup.settings
        if replace(accepted, analyzer=wanted.analyzer) != wanted:
            raise _other_settings(_sweep_in_words(accepted), _sweep_in_words(wanted))
        if not accepted.analyzer.fulfils(wanted.analyzer):
            raise _other_settings(accepted.analyzer.message, wanted.analyzer.message)
        # Other settings, such as the output power, can have changed it.
        calibration = self._call(analyzer.calibration, Message("calibration status"))
        # What was left to the instrument stays as it is now: to the end of the survey.
        self._wanted, self._setup = accepted, setup
        return AnalyzerState(
            identity, calibration.status, accepted, setup.sweep_duration_s, calibration.details
        )

    def _call(
        self, call: Callable[[], Result], action: Message, limit_s: Optional[float] = None
    ) -> Result:
        if limit_s is None:
            limit_s = self._robot.description.limits.analyzer_limit_s
        with self._waits.shown(ExpectedWait(THE_ANALYZER, action, 0.0, limit_s)) as check:
            return self._robot.analyzer_calls.call(call, check)


def _other_settings(found: Message, wanted: Message) -> DeviceError:
    return DeviceError(
        Message(
            "the VNA has {found} instead of {wanted}; do not change its settings during a survey; "
            "if it is so again, correct the plan",
            found=found,
            wanted=wanted,
        ),
        fault=VNA_SETTINGS,
    )


def _sweep_in_words(sweep: SweepSettings) -> Message:
    return Message(
        "{points} points from {start_mhz:.12g} to {stop_mhz:.12g} MHz",
        points=sweep.points,
        start_mhz=1.0e-6 * sweep.start_frequency_hz,
        stop_mhz=1.0e-6 * sweep.stop_frequency_hz,
    )
