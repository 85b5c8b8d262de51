"""The checks before a survey, and again before it goes on after a pause."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Callable, Optional

import numpy as np

from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.background import DeviceTurns, in_background, result_of
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.robot import ReopenedSurvey, Robot, SurveyRecord
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_settings import HeightPolicy, SurveySettings
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

NO_FREQUENCIES = np.empty(0)


@dataclass(frozen=True)
class InstrumentState:
    """What is known of the analyzer before a survey."""

    identity: str
    calibration: CalibrationStatus
    settings: SweepSettings


def interruption_remark(interrupted: str) -> str:
    """Return what is told of a survey that was still open when another began, if any."""
    if not interrupted:
        return ""
    return (
        f"; survey {interrupted} was still open and is closed as interrupted; resume_survey "
        "goes on with it later"
    )


class Preparation:
    """Brings the robot into the state in which the next point can be measured."""

    def __init__(
        self,
        parameters: SurveyParameters,
        settings: SurveySettings,
        robot: Robot,
        positioner: Positioner,
        interruption: Interruption,
        turns: DeviceTurns,
        make_record: Callable[[InstrumentState], SurveyRecord],
        reopened: Optional[ReopenedSurvey] = None,
    ) -> None:
        self._parameters = parameters
        self._settings = settings
        self._robot = robot
        self._positioner = positioner
        self._interruption = interruption
        self._turns = turns
        self._make_record = make_record
        self._instrument = InstrumentState("", CalibrationStatus.NONE, SweepSettings(0.0, 0.0, 0))
        self._recorded = self._instrument
        self._record: Optional[SurveyRecord] = None
        self._folder = "" if reopened is None else reopened.folder
        last = None if reopened is None else reopened.last
        self._frequencies_hz = NO_FREQUENCIES if last is None else last.frequency_hz

    @property
    def survey_is_open(self) -> bool:
        """Whether the survey has a folder."""
        return bool(self._folder)

    @property
    def folder(self) -> str:
        """The survey's folder; empty before it is made."""
        return self._folder

    @property
    def frequencies_hz(self) -> np.ndarray:
        """Frequencies of every sweep [Hz]."""
        return self._frequencies_hz

    def check(self) -> None:
        """Check everything that the survey needs; nothing moves.

        Raises:
            DeviceError: Something is missing or not as it should be.
        """
        self._positioner.check_alive()
        self.check_analyzer()
        if self._settings.on_height_failure == HeightPolicy.PAUSE.value:
            height_call = in_background(self._robot.height_sensor.height_m)
            result_of(height_call, self._interruption.check)

    def check_analyzer(self) -> None:
        """Connect the analyzer, look at its calibration and configure its sweep.

        Raises:
            DeviceError: It is not there, not calibrated, or refuses the sweep.
        """
        check = self._interruption.check
        analyzer, turns = self._robot.analyzer, self._turns.analyzer
        identity = turns.take(lambda: analyzer.connect(self._parameters.vna_address), check)
        calibration = turns.take(analyzer.calibration, check)
        settings = self._configure()
        frequencies_hz = turns.take(analyzer.frequencies_hz, check)
        if len(self._frequencies_hz) and not np.array_equal(frequencies_hz, self._frequencies_hz):
            raise DeviceError(
                "the VNA's frequencies are no longer those of this survey; stop it and start anew"
            )
        self._frequencies_hz = frequencies_hz
        self._instrument = InstrumentState(identity, calibration, settings)

    def open_survey(self, check: Optional[Callable[[], None]] = None) -> str:
        """Make the survey's folder and begin its recordings, or see that they are still open.

        The storage may have been restarted since; opening an open survey changes nothing.

        Args:
            check: Called again and again meanwhile, instead of the usual look at a stop and
                at the nodes; what it raises ends the wait.

        Returns:
            A remark for the operator on a survey that was still open; else nothing.

        Raises:
            DeviceError: There is no room, or the folder cannot be made.
        """
        if self._folder:
            name = PurePosixPath(self._folder).name
            self._turns.storage.take(
                lambda: self._robot.storage.reopen(name), check or self._interruption.check
            )
            return ""
        record = self._record_now()
        opened = self._turns.storage.take(
            lambda: self._robot.storage.open(record), self._interruption.check
        )
        self._folder = opened.folder
        return interruption_remark(opened.interrupted)

    def _record_now(self) -> SurveyRecord:
        # The same again if the answer to the first call was lost: the storage knows it by that.
        if self._record is None or self._recorded != self._instrument:
            self._record = self._make_record(self._instrument)
            self._recorded = self._instrument
        return self._record

    def check_sweep(self, sweep: Sweep) -> None:
        """Refuse a sweep that is not this survey's.

        Raises:
            DeviceError: Somebody set up another sweep.
        """
        frequency_hz = sweep.frequency_hz
        if not np.array_equal(frequency_hz, self._frequencies_hz):
            measured = SweepSettings(
                float(frequency_hz[0]), float(frequency_hz[-1]), len(frequency_hz)
            )
            raise DeviceError(
                f"the VNA measured {measured} instead of {self._parameters.sweep_settings}; "
                "nobody else may set it up during a survey"
            )

    def _configure(self) -> SweepSettings:
        asked = self._parameters.sweep_settings
        accepted = self._turns.analyzer.take(
            lambda: self._robot.analyzer.configure(asked), self._interruption.check
        )
        if accepted != asked:
            raise DeviceError(f"the VNA accepted {accepted} instead of {asked}")
        return accepted
