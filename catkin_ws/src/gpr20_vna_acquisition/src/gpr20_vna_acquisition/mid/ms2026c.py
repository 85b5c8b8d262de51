"""The commands and queries of one connected MS2026C."""

from __future__ import annotations

from typing import Callable, List, Protocol, Sequence, Tuple

from gpr20_common.message import Message, in_a_row
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaDataError,
    VnaIdentityError,
    VnaSettingError,
    VnaSweepError,
)
from gpr20_vna_acquisition.mid import settings
from gpr20_vna_acquisition.mid.block_parser import (
    number,
    parse_frequencies,
    parse_numbers,
    whole_number,
)
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.settings import Setting, unquoted
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SWEEP_COMPLETE_BIT = 256
IDENTITY_FIELDS = 4
# Options follow the model, "MS2026C/2"; this one transforms traces to the time domain.
TIME_DOMAIN_OPTION = "2"
# A start above the previous stop may be refused until the new stop is set: send all twice.
SETTING_PASSES = 2
SETTING_POLL_S = 0.05
# Polling more often than this loads the instrument and gains nothing.
SHORTEST_POLL_S = 0.0005
POLL_FRACTION = 0.1


class Transport(Protocol):
    """One link. Every call may raise VnaConnectionError; after that the link is dead."""

    def write(self, command: str) -> None:
        """Send a command that has no answer."""

    def ask(self, query: str) -> str:
        """Send a query and return its answer as text without white space around it."""

    def ask_raw(self, query: str) -> bytes:
        """Send a query and return its answer, byte for byte."""

    def clear(self) -> None:
        """Empty the instrument's input and output."""

    def close(self) -> None:
        """End the link; never fails."""


class Ms2026c:
    """Controls the instrument over one link.

    It never sends `*RST`, which would reset the instrument's network settings.
    """

    def __init__(
        self,
        transport: Transport,
        parameters: VnaParameters,
        deadline: RequestDeadline,
        utc_now_us: Callable[[], int],
    ) -> None:
        """Use a link.

        Args:
            transport: The link.
            parameters: What is expected of the instrument.
            deadline: Ends a request that takes too long.
            utc_now_us: Returns the time of day [us since 1970, UTC].
        """
        self._transport = transport
        self._parameters = parameters
        self._deadline = deadline
        self._utc_now_us = utc_now_us
        self._has_time_domain = False

    def close(self) -> None:
        """End the link."""
        self._transport.close()

    def identify(self) -> str:
        """Return the identification: maker, model/options, serial number, firmware.

        Raises:
            VnaIdentityError: It is not the expected instrument.
        """
        if self._parameters.clear_on_connect:
            self._transport.clear()
        identity = unquoted(self._ask("*IDN?"))
        fields = [field.strip() for field in identity.split(",")]
        expected = (self._parameters.maker, self._parameters.model)
        model, *options = fields[1].split("/") if len(fields) == IDENTITY_FIELDS else [""]
        if (fields[0], model) != expected:
            raise VnaIdentityError(
                Message(
                    "the VNA identifies itself as {identity}; expected {maker} {model}; check its "
                    "address, or the parameters maker and model",
                    identity=repr(_printable(identity[:40])),
                    maker=expected[0],
                    model=expected[1],
                    details=repr(identity[:200]),
                )
            )
        self._has_time_domain = TIME_DOMAIN_OPTION in options
        return identity

    def set_frequency_sweep(self, sweep: SweepSettings) -> SweepSettings:
        """Set the frequencies and return those that the instrument confirms.

        Raises:
            VnaSettingError: The instrument did not accept a setting.
            VnaDataError: It accepted them, but measures other frequencies.
        """
        wanted = settings.frequency_settings(sweep)
        self._apply(wanted)
        start, stop, points = (self._ask(setting.query) for setting in wanted[1:])
        accepted = SweepSettings(number(start), number(stop), whole_number(points))
        if accepted.points != sweep.points:
            raise VnaSettingError(
                Message(
                    "the VNA's number of points changed to {points} by itself; check that nobody "
                    "operates it by hand",
                    points=accepted.points,
                )
            )
        answer = self._ask_raw(":SENSE1:FREQ:DATA?")
        settings.check_frequencies(parse_frequencies(answer, accepted.points), accepted)
        return accepted

    def set_trace(self) -> None:
        """Set up one trace of S21 over frequency, without averaging.

        Raises:
            VnaSettingError: The instrument did not accept a setting.
        """
        transfer = self._parameters.transfer_format
        self._apply(settings.trace_settings(transfer, self._has_time_domain))

    def calibration_status(self) -> CalibrationStatus:
        """Return the state of the calibration.

        Raises:
            VnaDataError: The answer is not on the documented scale.
        """
        status = whole_number(self._ask(":SENS:CORR:COLL:STAT:ACC?"))
        try:
            return CalibrationStatus(status)
        except ValueError as error:
            raise VnaDataError(
                Message(
                    "the VNA reports calibration status {status}; expected 0 to 4", status=status
                )
            ) from error

    def sweep(self, sweep: SweepSettings) -> Sweep:
        """Trigger one sweep, wait for its end and return its data.

        Args:
            sweep: What `set_frequency_sweep` returned.

        Raises:
            VnaSweepError: It did not end in time.
            VnaDataError: The data are incomplete or not finite.
            VnaSettingError: A setting was changed by hand.
        """
        # A sweep that is already running began before the request and must not be used.
        self._apply([settings.HOLD])
        started_us, started_s = self._utc_now_us(), self._deadline.now_s()
        self._write(":INIT:IMM")
        self._wait_for_end(sweep.points)
        # By the monotonic clock: the time of day may be corrected meanwhile.
        duration_us = round((self._deadline.now_s() - started_s) * utc_time.US_PER_S)
        answer = self._ask_raw(":CALC1:DATA? SDAT")
        # Checked after the data arrived, so that a change before or during the transfer is seen.
        self._check_unchanged(sweep)
        numbers = parse_numbers(answer, self._parameters.transfer_format, 2 * sweep.points)
        return Sweep(
            frequency_hz=sweep.frequencies_hz(),
            s21_real=numbers[0::2].copy(),
            s21_imag=numbers[1::2].copy(),
            sweep_started_us=started_us,
            sweep_ended_us=started_us + duration_us,
            quality=(),
            analyzer=AnalyzerSettings(),
        )

    def _wait_for_end(self, points: int) -> None:
        begun_s = self._deadline.now_s()
        seen_running = False
        while True:
            elapsed_s = self._deadline.now_s() - begun_s
            complete = self._sweep_is_complete()
            seen_running = seen_running or not complete
            # INIT:IMM clears the bit, but the manual does not define how soon. A bit that was
            # never seen cleared may be that of the previous sweep; it counts only when the
            # sweep must have ended anyway.
            if complete and (seen_running or elapsed_s >= self._parameters.nominal_sweep_s(points)):
                return
            limit_s = self._parameters.sweep_limit_s(points)
            if elapsed_s >= limit_s:
                raise VnaSweepError(
                    Message(
                        "the sweep of {points} points did not end within {limit_s:.3g} s; check "
                        "that the VNA is in VNA mode and not operated by hand",
                        points=points,
                        limit_s=limit_s,
                    )
                )
            longest_s = self._parameters.poll_interval_s
            self._deadline.pause_s(min(longest_s, max(SHORTEST_POLL_S, POLL_FRACTION * elapsed_s)))

    def _sweep_is_complete(self) -> bool:
        status = whole_number(self._ask(":STAT:OPER?"))
        return bool(status & SWEEP_COMPLETE_BIT)

    def _check_unchanged(self, sweep: SweepSettings) -> None:
        changed = self._differing(settings.watched_settings(sweep, self._has_time_domain))
        if changed:
            raise VnaSettingError(
                Message(
                    "the VNA's settings were changed during the sweep: {settings}; do not operate "
                    "it by hand during a survey",
                    settings=_described(changed),
                )
            )

    def _apply(self, wanted: Sequence[Setting]) -> None:
        refused: List[Tuple[Setting, str]] = []
        for _ in range(SETTING_PASSES):
            for setting in wanted:
                self._write(setting.command)
            refused = self._unconfirmed(wanted)
            if not refused:
                return
        raise VnaSettingError(
            Message(
                "the VNA did not accept a setting: {settings}; check that it is in VNA mode and "
                "not operated by hand",
                settings=_described(refused),
            )
        )

    def _unconfirmed(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, str]]:
        deadline_s = self._deadline.now_s() + self._parameters.settle_s
        while True:
            # All of them each time: one setting may change another.
            refused = self._differing(wanted)
            if not refused or self._deadline.now_s() >= deadline_s:
                return refused
            self._deadline.pause_s(SETTING_POLL_S)

    def _differing(self, wanted: Sequence[Setting]) -> List[Tuple[Setting, str]]:
        answers = [(setting, self._ask(setting.query)) for setting in wanted]
        return [(setting, answer) for setting, answer in answers if not setting.agrees(answer)]

    def _write(self, command: str) -> None:
        self._deadline.check()
        self._transport.write(command)

    def _ask(self, query: str) -> str:
        self._deadline.check()
        return self._transport.ask(query)

    def _ask_raw(self, query: str) -> bytes:
        self._deadline.check()
        return self._transport.ask_raw(query)


def _printable(text: str) -> str:
    """Return a text from the instrument for a sentence: "?" instead of what has no place in it."""
    return "".join(one if one.isascii() and one.isprintable() else "?" for one in text)


def _described(differing: Sequence[Tuple[Setting, str]]) -> Message:
    return in_a_row(
        Message(
            "{setting} is {found} instead of {expected}",
            setting=setting.name,
            found=repr(unquoted(answer)[:40]),
            expected=setting.value,
            details=f"{setting.query} answers {answer[:40]!r}",
        )
        for setting, answer in differing
    )
