"""The Anritsu MS2026C."""

from __future__ import annotations

from typing import Any, Callable, Collection, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_survey.faults import VNA_DOUBTFUL
from gpr20_survey.trace.sweep import AnalyzerSettings, CalibrationStatus, Sweep, SweepSettings
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid import ms2026c_commands as commands
from gpr20_vna_acquisition.mid.block_parser import number, parse_frequencies, whole_number
from gpr20_vna_acquisition.mid.exchanges import Exchanges, RequestDeadline, Transport
from gpr20_vna_acquisition.mid.ms2026c_commands import (
    Answers,
    Command,
    Preamble,
    Setting,
    check_frequencies,
    described,
    differing,
    word,
)
from gpr20_vna_acquisition.mid.ms2026c_sweeps import Ms2026cSweeps
from gpr20_vna_acquisition.mid.trace_quality import calibration_lost
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# A start above the previous stop may be refused until the new stop is set: send all twice.
SETTING_PASSES = 2
SETTING_POLL_S = 0.05
NEEDED = "S21"


class Ms2026c:
    """Implements `Analyzer`."""

    def __init__(
        self,
        connector: Callable[[str], Transport],
        parameters: VnaParameters,
        deadline: RequestDeadline,
        utc_now_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        """Begin without a link; `connector` opens one to an address.

        `utc_now_us` returns the time of day [us since 1970, UTC].
        """
        self._parameters = parameters
        self._deadline = deadline
        self._exchanges = Exchanges(connector, deadline, parameters.unanswered_queries)
        self._sweeps = Ms2026cSweeps(self._exchanges, parameters, deadline, utc_now_us)
        # Which S-parameters are calibrated; None if it does not say.
        self._calibrated: Optional[Tuple[str, ...]] = None
        self._identity = ""
        self._accepted: Optional[SweepSettings] = None
        # What it said of its trace when it was set up, if it does.
        self._preamble: Optional[Preamble] = None
        # At the last `confirm` [degC]; None if it does not say.
        self.temperature_c: Optional[float] = None

    def connect(self, address: str) -> None:
        """Open a link to an address, four decimal numbers; an open one is closed."""
        ipv4_address(Message("the VNA address"), address)
        limits = self._parameters
        self._exchanges.open(address, limits.lock_instrument, limits.clear_on_connect)

    def identify(self) -> str:
        """Return the identification: maker, model/options, serial number, firmware."""
        identity = self._exchanges.ask(commands.IDENTITY_QUERY)
        self._parameters.check_identity(identity)
        if identity != self._identity:
            self._accepted = None
        self._identity = identity
        return identity

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have."""
        self._parameters.check_sweep(settings)

    def configure(self, sweep: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes."""
        self._accepted = None
        self._look_at_calibration()
        calibration = self.calibration()
        written, answers = self._apply(self._settings(sweep))
        self._check_calibration_kept(calibration, written)
        start, stop = number(answers[commands.START]), number(answers[commands.STOP])
        points = whole_number(answers[commands.POINTS])
        analyzer = self._analyzer_settings(sweep.analyzer.averages)
        accepted = SweepSettings(start, stop, points, analyzer)
        frequencies = self._exchanges.ask_optional_raw(commands.FREQUENCIES.query)
        if frequencies is not None:
            check_frequencies(parse_frequencies(frequencies, points), accepted)
        self._sweeps.learn(accepted)
        self._preamble = self._read_preamble()
        if self._preamble is not None:
            self._preamble.check_unprocessed()
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
        accepted, preamble = self._configured(), self._check_preamble()
        if not self._sweeps.is_unproven:
            self._check_settings(accepted, preamble)
            return
        self._check_settings(accepted, preamble, (commands.FORMAT,))
        try:
            self._sweeps.prove(accepted)
        except VnaDataError:
            # A setting that was changed meanwhile, such as the format, is the cause.
            self._check_settings(accepted, self._check_preamble())
            raise

    def calibration(self) -> CalibrationStatus:
        """Return its accuracy; a calibration that lacks S21, when last looked at, is none."""
        status = whole_number(self._exchanges.ask(commands.ACCURACY_QUERY))
        if not CalibrationStatus.NONE <= status <= CalibrationStatus.LOW:
            raise VnaDataError(
                Message(
                    "the VNA reports calibration status {status}; expected 0 to 4", status=status
                )
            )
        lacks_s21 = self._calibrated is not None and NEEDED not in self._calibrated
        return CalibrationStatus.NONE if lacks_s21 else CalibrationStatus(status)

    def calibration_details(self) -> Mapping[str, Any]:
        """Return what else the instrument says of its calibration."""
        self._look_at_calibration()
        preamble = self._read_preamble()
        found = {
            "parameters": None if self._calibrated is None else list(self._calibrated),
            "is_corrected": preamble and preamble.is_corrected,
            "temperature_c": preamble and preamble.temperature_c,
        }
        return {name: value for name, value in found.items() if value is not None}

    def _look_at_calibration(self) -> None:
        answer = self._exchanges.ask_optional(commands.CALIBRATED.query)
        mask = None if answer is None else whole_number(answer)
        bits = commands.CALIBRATED_BITS.items()
        self._calibrated = None if mask is None else tuple(one for one, bit in bits if mask & bit)

    def release(self) -> None:
        """Leave the instrument sweeping by itself, with its front panel usable."""
        self._exchanges.release(commands.RELEASE)

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
        return [
            Message(
                "the VNA does not report {setting}; it is not checked",
                setting=commands.OPTIONAL[query].name,
                details=query,
            ).with_fault(VNA_DOUBTFUL)
            for query in self._parameters.unanswered_queries
        ]

    def _settings(self, sweep: SweepSettings) -> List[Setting]:
        return commands.trace_settings(sweep, self._parameters.transfer_format)

    def _check_settings(
        self,
        accepted: SweepSettings,
        preamble: Optional[Preamble] = None,
        known: Collection[Command] = (),
    ) -> None:
        """Ask for every setting that is neither known to be right nor covered by a preamble."""
        wanted = [
            setting
            for setting in self._settings(accepted)
            if setting.command not in known and not (preamble and preamble.covers(setting.command))
        ]
        changed = differing(self._answers(wanted))
        if changed:
            raise errors.settings_changed(described(changed))

    def _check_preamble(self) -> Optional[Preamble]:
        """Compare what the instrument says of its trace with what it said; None if it does not."""
        before, now = self._preamble, self._read_preamble()
        if before is None or now is None:
            identity = self._exchanges.ask(commands.IDENTITY_QUERY)
            if identity != self._identity:
                raise errors.replaced(identity, self._identity)
            return None
        changes = before.changes(now)
        if changes is not None:
            raise errors.settings_changed(changes)
        self.temperature_c = now.temperature_c
        return before

    def _read_preamble(self) -> Optional[Preamble]:
        answer = self._exchanges.ask_optional_raw(commands.PREAMBLE.query)
        return None if answer is None else Preamble(answer)

    def _configured(self) -> SweepSettings:
        if self._accepted is None:
            raise errors.not_configured()
        return self._accepted

    def _apply(self, wanted: Sequence[Setting]) -> Tuple[List[Command], Dict[Command, str]]:
        """Make the settings that differ; return those, and the last answer of each."""
        answers = self._answers(wanted)
        written: List[Command] = []
        for _ in range(SETTING_PASSES):
            for setting, _answer in differing(answers):
                written.append(setting.command)
                self._exchanges.write(f"{setting.command.header} {setting.sent}")
            if not differing(answers):
                break
            answers = self._answers_when_settled(wanted)
        refused = differing(answers)
        if refused:
            raise errors.settings_refused(described(refused))
        return written, {setting.command: answer for setting, answer in answers}

    def _answers_when_settled(self, wanted: Sequence[Setting]) -> Answers:
        deadline_s = self._deadline.now_s() + self._parameters.settle_s
        while True:
            # All of them each time: one setting may change another.
            answers = self._answers(wanted)
            if not differing(answers) or self._deadline.now_s() >= deadline_s:
                return answers
            self._deadline.pause_s(SETTING_POLL_S)

    def _answers(self, wanted: Sequence[Setting]) -> Answers:
        found = []
        for setting in wanted:
            can_miss = setting.command in commands.NEEDLESS
            ask = self._exchanges.ask_optional if can_miss else self._exchanges.ask
            answer = ask(setting.command.query)
            if answer is not None:
                found.append((setting, answer))
        return found

    def _analyzer_settings(self, averages: int) -> AnalyzerSettings:
        bandwidth = self._exchanges.ask_optional(commands.BANDWIDTH.query)
        power = self._exchanges.ask_optional(commands.POWER.query)
        return AnalyzerSettings(
            if_bandwidth_hz=0.0 if bandwidth is None else number(bandwidth),
            averages=max(1, averages),
            output_power="" if power is None else word(power),
        )

    def _check_calibration_kept(
        self, before: CalibrationStatus, written: Sequence[Command]
    ) -> None:
        if not written or before is CalibrationStatus.NONE:
            return
        if self.calibration() is CalibrationStatus.NONE:
            # Without hold no sweep can be triggered; it is named only where nothing else is.
            others = [one for one in written if one is not commands.HOLD]
            raise calibration_lost(one.name for one in dict.fromkeys(others or written))
