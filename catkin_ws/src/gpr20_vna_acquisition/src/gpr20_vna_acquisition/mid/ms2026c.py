"""The Anritsu MS2026C.

Commands: MS20xxC programming manual (Anritsu 10580-00306), chapters 2 and 3.
"""

from __future__ import annotations

from typing import Any, Callable, Collection, Dict, List, Optional, Sequence, Tuple

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_survey.faults import VNA_DOUBTFUL
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid import refusals, settings
from gpr20_vna_acquisition.mid.block_parser import number, parse_frequencies, whole_number
from gpr20_vna_acquisition.mid.exchanges import Exchanges, Transport
from gpr20_vna_acquisition.mid.identity import check_identity
from gpr20_vna_acquisition.mid.ms2026c_calibration import CALIBRATED_QUERY, Ms2026cCalibration
from gpr20_vna_acquisition.mid.ms2026c_sweeps import Ms2026cSweeps
from gpr20_vna_acquisition.mid.preamble import PREAMBLE_QUERY, Preamble, changed_values, replaced
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.settings import Setting, described, unquoted
from gpr20_vna_acquisition.mid.trace_quality import calibration_lost
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# Options follow the model, "MS2026C/2"; this one transforms traces to the time domain.
TIME_DOMAIN_OPTION = "2"
# A start above the previous stop may be refused until the new stop is set: send all twice.
SETTING_PASSES = 2
SETTING_POLL_S = 0.05
FREQUENCIES_QUERY = ":SENSE1:FREQ:DATA?"
RELEASE = ":INIT:CONT ON"


class Ms2026c:
    """Implements `Analyzer`.

    It never sends `*RST`, which would reset the instrument's network settings.
    """

    def __init__(
        self,
        connector: Callable[[str], Transport],
        parameters: VnaParameters,
        deadline: RequestDeadline,
        utc_now_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        """Begin without a link.

        Args:
            connector: Opens a link to an address, or raises VnaConnectionError.
            parameters: What is expected of the instrument.
            deadline: Ends a request that takes too long.
            utc_now_us: Returns the time of day [us since 1970, UTC].
        """
        self._parameters = parameters
        self._deadline = deadline
        self._exchanges = Exchanges(connector, deadline)
        self._sweeps = Ms2026cSweeps(self._exchanges, parameters, deadline, utc_now_us)
        self._calibration = Ms2026cCalibration(self._exchanges)
        self._identity = ""
        self._accepted: Optional[SweepSettings] = None
        # What it said of its trace when it was set up, if it does.
        self._preamble: Optional[Preamble] = None
        self._temperature_c: Optional[float] = None

    def connect(self, address: str) -> None:
        """Open a link to an address, four decimal numbers; an open one is closed."""
        ipv4_address(Message("the VNA address"), address)
        self._exchanges.open(address, self._parameters.lock_instrument)
        if self._parameters.clear_on_connect:
            self._exchanges.clear()

    def identify(self) -> str:
        """Return the identification: maker, model/options, serial number, firmware."""
        identity = unquoted(self._exchanges.ask("*IDN?"))
        check_identity(identity, self._parameters)
        if identity != self._identity:
            self._exchanges.forget()
            self._accepted = None
        self._identity = identity
        return identity

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have."""
        self._parameters.check_sweep(settings)

    def configure(self, sweep: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        self._accepted = None
        self._calibration.look()
        calibration = self.calibration()
        written, answers = self._apply(self._settings(sweep))
        self._check_calibration_kept(calibration, written)
        start, stop, points = (answers[header] for header in settings.FREQUENCY_HEADERS)
        accepted = SweepSettings(
            number(start), number(stop), whole_number(points), self._analyzer_settings()
        )
        self._check_frequencies(accepted)
        self._sweeps.learn(accepted)
        self._preamble = self._unprocessed_preamble()
        # Between the settings and what the preamble says of them none was changed.
        self._check_settings(accepted)
        self._accepted = accepted
        return accepted

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data."""
        return self._sweeps.take(self._configured())

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`.

        After a sweep its data are read again. That they are the same shows their format too.
        """
        accepted, display = self._configured(), self._sweeps.display
        preamble = self._check_preamble(accepted)
        if display.is_proven:
            self._check_settings(accepted, preamble)
            return
        self._check_settings(accepted, preamble, (settings.TRANSFER_FORMAT,))
        try:
            display.prove(accepted)
        except VnaDataError:
            # A setting that was changed meanwhile, such as the format, is the cause.
            self._check_settings(accepted, self._check_preamble(accepted))
            raise

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration."""
        return self._calibration.status()

    def calibration_details(self) -> Dict[str, Any]:
        """Return what else the instrument says of its calibration, and of its trace."""
        return self._calibration.details(self._read_preamble())

    @property
    def temperature_c(self) -> Optional[float]:
        """Its temperature at the last `confirm` [degC]; None if it does not say."""
        return self._temperature_c

    @property
    def has_noise(self) -> bool:
        """Whether two of its sweeps always differ in some bit."""
        return True

    def forget(self) -> None:
        """Forget which queries it does not answer: it is set up again."""
        self._exchanges.forget()

    def release(self) -> None:
        """Leave the instrument sweeping by itself, with its front panel usable."""
        self._exchanges.release(RELEASE)

    def disconnect(self) -> None:
        """End the link; never fails, and does nothing without one."""
        self._exchanges.close()

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes, with its averages [s]; None before `configure`."""
        return self._sweeps.trace_duration_s if self._accepted else None

    @property
    def remarks(self) -> Sequence[Message]:
        """Which queries this instrument does not answer."""
        optional = {
            settings.FREQUENCY_DOMAIN.query: settings.FREQUENCY_DOMAIN.name,
            settings.ONE_TRACE.query: settings.ONE_TRACE.name,
            settings.IF_BANDWIDTH_QUERY: settings.IF_BANDWIDTH,
            settings.POWER_QUERY: settings.OUTPUT_POWER,
            FREQUENCIES_QUERY: Message("the list of frequencies"),
            PREAMBLE_QUERY: Message("the description of its trace"),
            CALIBRATED_QUERY: Message("which S-parameters are calibrated"),
        }
        return [
            Message(
                "the VNA does not report {setting}; it is not checked", setting=name, details=query
            ).with_fault(VNA_DOUBTFUL)
            for query, name in optional.items()
            if self._exchanges.never_answered(query)
        ]

    def _settings(self, sweep: SweepSettings) -> List[Setting]:
        options = self._identity.split(",")[1].split("/")[1:]
        transfer = self._parameters.transfer_format
        return settings.trace_settings(sweep, transfer, TIME_DOMAIN_OPTION in options)

    def _check_settings(
        self,
        accepted: SweepSettings,
        preamble: Optional[Preamble] = None,
        known: Collection[str] = (),
    ) -> None:
        """Ask for every setting that is neither known to be right nor covered by a preamble."""
        wanted = [
            setting
            for setting in self._settings(accepted)
            if setting.header not in known and not (preamble and preamble.covers(setting.header))
        ]
        changed = _differing(self._answers(wanted))
        if changed:
            raise refusals.settings_changed(described(changed))

    def _check_preamble(self, accepted: SweepSettings) -> Optional[Preamble]:
        """Compare what the instrument says of its trace with what it said; None if it does not."""
        before, now = self._preamble, self._read_preamble()
        if before is None or now is None:
            identity = self._exchanges.ask("*IDN?")
            if identity != self._identity:
                raise replaced(identity, self._identity)
            return None
        changed = before.differing(now)
        if changed:
            names = {setting.header: setting.name for setting in self._settings(accepted)}
            raise refusals.settings_changed(changed_values(changed, names))
        self._temperature_c = now.temperature_c
        return before

    def _read_preamble(self) -> Optional[Preamble]:
        answer = self._exchanges.ask_optional_raw(PREAMBLE_QUERY)
        return None if answer is None else Preamble(answer)

    def _unprocessed_preamble(self) -> Optional[Preamble]:
        preamble = self._read_preamble()
        if preamble is not None:
            preamble.check_unprocessed()
        return preamble

    def _configured(self) -> SweepSettings:
        if self._accepted is None:
            raise refusals.not_configured()
        return self._accepted

    def _apply(self, wanted: Sequence[Setting]) -> Tuple[List[Setting], Dict[str, str]]:
        """Make the settings that differ; return them, and the last answer for each header."""
        answers = self._answers(wanted)
        written: Dict[str, Setting] = {}
        for _ in range(SETTING_PASSES):
            differing = [setting for setting, _answer in _differing(answers)]
            if not differing:
                break
            for setting in differing:
                written[setting.header] = setting
                self._exchanges.write(setting.command)
            answers = self._answers_when_settled(wanted)
        refused = _differing(answers)
        if refused:
            raise refusals.settings_refused(described(refused))
        return list(written.values()), {setting.header: answer for setting, answer in answers}

    def _answers_when_settled(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, str]]:
        deadline_s = self._deadline.now_s() + self._parameters.settle_s
        while True:
            # All of them each time: one setting may change another.
            answers = self._answers(wanted)
            if not _differing(answers) or self._deadline.now_s() >= deadline_s:
                return answers
            self._deadline.pause_s(SETTING_POLL_S)

    def _answers(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, str]]:
        found = []
        for setting in wanted:
            ask = self._exchanges.ask if setting.required else self._exchanges.ask_optional
            answer = ask(setting.query)
            if answer is not None:
                found.append((setting, answer))
        return found

    def _analyzer_settings(self) -> AnalyzerSettings:
        bandwidth = self._exchanges.ask_optional(settings.IF_BANDWIDTH_QUERY)
        power = self._exchanges.ask_optional(settings.POWER_QUERY)
        # An average that is not known of could mix sweeps from before and after a move.
        averages = whole_number(self._exchanges.ask(settings.AVERAGES_QUERY))
        if averages < 1:
            raise VnaDataError(
                Message(
                    "the VNA reports {averages} averages; expected 1 or more", averages=averages
                )
            )
        return AnalyzerSettings(
            if_bandwidth_hz=0.0 if bandwidth is None else number(bandwidth),
            averages=averages,
            output_power="" if power is None else unquoted(power).upper(),
        )

    def _check_calibration_kept(
        self, before: CalibrationStatus, written: Sequence[Setting]
    ) -> None:
        if not written or before is CalibrationStatus.NONE:
            return
        if self.calibration() is not CalibrationStatus.NONE:
            return
        # Without hold no sweep can be triggered; it is named only where nothing else was written.
        others = [one for one in written if one is not settings.HOLD]
        raise calibration_lost(one.name for one in others or written)

    def _check_frequencies(self, accepted: SweepSettings) -> None:
        answer = self._exchanges.ask_optional_raw(FREQUENCIES_QUERY)
        if answer is not None:
            reported_hz = parse_frequencies(answer, accepted.points)
            settings.check_frequencies(reported_hz, accepted)


def _differing(answers: Sequence[Tuple[Setting, str]]) -> List[Tuple[Setting, str]]:
    return [(setting, answer) for setting, answer in answers if not setting.agrees(answer)]
