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
from gpr20_main_control.mid.robot import (
    AnalyzerSweep,
    ReopenedSurvey,
    Robot,
    SurveyRecord,
    SweepSetting,
)
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_settings import HeightPolicy, SurveySettings

NO_FREQUENCIES = np.empty(0)
CALIBRATION_MEANINGS = {
    0: "no calibration",
    1: "calibrated, accuracy high",
    2: "moderate, the power level was changed",
    3: "moderate, the temperature moved by more than 5 degrees",
    4: "low, the temperature moved by more than 10 degrees",
}


@dataclass(frozen=True)
class InstrumentState:
    """What is known of the analyzer before a survey."""

    identity: str
    calibration: int
    setting: SweepSetting


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
        self._instrument = InstrumentState("", 0, SweepSetting(0.0, 0.0, 0))
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

    def check_analyzer(self, check: Optional[Callable[[], None]] = None) -> None:
        """Connect the analyzer, look at its calibration and configure its sweep.

        Args:
            check: Called again and again meanwhile, instead of the usual look at a stop and
                at the nodes; what it raises ends the wait.

        Raises:
            DeviceError: It is not there, not calibrated, or refuses the sweep.
        """
        check = check or self._interruption.check
        analyzer, turns = self._robot.analyzer, self._turns.analyzer
        identity = turns.take(lambda: analyzer.connect(self._parameters.vna_address), check)
        calibration = turns.take(analyzer.calibration, check)
        self._check_calibration(calibration)
        setting = self._configure(check)
        frequencies_hz = turns.take(analyzer.frequencies_hz, check)
        if len(self._frequencies_hz) and not np.array_equal(frequencies_hz, self._frequencies_hz):
            raise DeviceError(
                "the VNA's frequencies are no longer those of this survey; stop it and start anew"
            )
        self._frequencies_hz = frequencies_hz
        self._instrument = InstrumentState(identity, calibration, setting)

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

    def check_sweep(self, sweep: AnalyzerSweep) -> None:
        """Refuse a sweep that is not this survey's, or was made without calibration.

        Raises:
            DeviceError: Somebody set up another sweep, or the calibration was lost.
        """
        if sweep.setting != self._asked_setting():
            raise DeviceError(
                f"the VNA measured {sweep.setting} instead of {self._asked_setting()}; nobody "
                "else may set it up during a survey"
            )
        self._check_calibration(sweep.calibration)

    def _check_calibration(self, status: int) -> None:
        if status not in self._settings.accepted_calibrations:
            meaning = CALIBRATION_MEANINGS.get(status, "unknown")
            accepted = ", ".join(str(one) for one in self._settings.accepted_calibrations)
            raise DeviceError(
                f"the VNA's calibration status is {status} ({meaning}); calibrate it, or "
                f"change accepted_calibrations (now {accepted})"
            )

    def _asked_setting(self) -> SweepSetting:
        return SweepSetting(
            self._parameters.start_frequency_hz,
            self._parameters.stop_frequency_hz,
            self._parameters.frequency_points,
        )

    def _configure(self, check: Callable[[], None]) -> SweepSetting:
        asked = self._asked_setting()
        accepted = self._turns.analyzer.take(lambda: self._robot.analyzer.configure(asked), check)
        if accepted != asked:
            raise DeviceError(f"the VNA accepted {accepted} instead of {asked}")
        return accepted
