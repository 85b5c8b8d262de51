"""The commands of an MS2026C that are sent, and what each answers.

Spellings and names are those of the MS20xxC programming manual (Anritsu 10580-00306), chapters 2
and 3. The instrument has no error queue: reading back is the only way to know whether it accepted a
setting. Which names a preamble has depends on the firmware.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.checks import Text
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_survey.trace.sweep import SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError, VnaSettingError, replaced
from gpr20_vna_acquisition.mid.block_parser import TransferFormat, number, text_block, unquoted

# The instrument may round to the resolution of its synthesizer.
RESOLUTION_HZ = 1.0
# Frequencies may be in single precision, rounded twice.
SINGLE_PRECISION = 2.0 * float(np.finfo(np.float32).eps)
# The temperature is in quarters of a degree, and only valid with a calibration.
QUARTERS_PER_DEGREE = 4.0
CORRECTION_ON = 0.0
_NUMBER = re.compile(r"[+-]?[0-9]{1,12}(?:\.[0-9]{0,12})?")


def word(answer: str) -> str:
    """Return an answer that is a word."""
    return unquoted(answer).upper()


@dataclass(frozen=True)
class Command:
    """One command.

    Attributes:
        name: What people call it.
        header: The command without value; with a question mark it is the query.
        read: Returns what an answer means, or raises VnaDataError.
        preamble: What a preamble calls it; one of several names is enough.
        optional: Whether the instrument need not answer, because the data do not depend on it.
        unit: Unit of the value; what is in hertz may differ by `RESOLUTION_HZ`.
        argument: What follows the question mark.
    """

    name: Message
    header: str
    read: Callable[[str], Any] = word
    preamble: Tuple[str, ...] = ()
    optional: bool = False
    unit: str = ""
    argument: str = ""

    @property
    def query(self) -> str:
        """The query."""
        return f"{self.header}?{self.argument}"


# In hold, the instrument sweeps only when triggered; `INIT:CONT?` answers 0 then.
HOLD = Command(Message("continuous sweep"), ":INIT:CONT", number, ("SWEEP_TYPE",))
START = Command(
    Message("the start frequency"), ":SENS:FREQ:STAR", number, ("TRACE_1_START_FREQ",), unit="Hz"
)
STOP = Command(
    Message("the stop frequency"), ":SENS:FREQ:STOP", number, ("TRACE_1_STOP_FREQ",), unit="Hz"
)
POINTS = Command(
    Message("the number of points"), ":SENS:SWE:POIN", number, ("TRACE_1_DSP_DATA_POINTS",)
)
# More traces on the display could only make the sweep slower.
TRACES = Command(
    Message("the number of traces"), ":SENS:TRAC:TOT", number, ("TOTAL_TRACE",), optional=True
)
S_PARAMETER = Command(
    Message("the S-parameter of trace 1"),
    ":SENS:TRACE1:SPAR",
    preamble=("TRACE_S_TYPES", "S_TYPE"),
)
DOMAIN = Command(
    Message("the domain of trace 1"),
    ":SENS:TRACE1:DOM",
    preamble=("TRACE_DOMAIN_TYPES", "DOMAIN"),
    optional=True,
)
BANDWIDTH = Command(
    Message("the IF bandwidth"), ":SENS:SWE:IFBW", number, ("IFBW",), optional=True, unit="Hz"
)
AVERAGES = Command(
    Message("the number of averages"), ":SENS:AVER:COUN", number, ("AVERAGING_FACTOR",)
)
POWER = Command(
    Message("the output power"), ":SOUR:POW", preamble=("RF_SOURCE_POWER",), optional=True
)
FORMAT = Command(Message("the transfer format"), ":FORM")
SETTINGS = (
    *(HOLD, START, STOP, POINTS, TRACES, S_PARAMETER, DOMAIN, BANDWIDTH, AVERAGES, POWER, FORMAT),
)
FREQUENCIES = Command(Message("the list of frequencies"), ":SENSE1:FREQ:DATA", optional=True)
PREAMBLE = Command(
    Message("the description of its trace"), ":TRAC:PRE", optional=True, argument=" 1"
)
CALIBRATED = Command(
    Message("which S-parameters are calibrated"), ":SENS:CAL:STAT", number, optional=True
)
# The data do not depend on them where the instrument does not have them.
NEEDLESS = (TRACES, DOMAIN)
OPTIONAL = {
    one.query: one for one in (*SETTINGS, FREQUENCIES, PREAMBLE, CALIBRATED) if one.optional
}
# The bits of the answer to `CALIBRATED`.
CALIBRATED_BITS = {"S11": 1, "S12": 2, "S21": 4, "S22": 8}
# Whole numbers: accuracy of the calibration, 0 to 4; bit 256, a sweep has ended.
ACCURACY_QUERY, STATUS_QUERY, SWEEP_COMPLETE_BIT = ":SENS:CORR:COLL:STAT:ACC?", ":STAT:OPER?", 256
# Maker, model/options, serial number, firmware; a block of complex numbers.
IDENTITY_QUERY, DATA_QUERY = "*IDN?", ":CALC1:DATA? SDAT"
# No answer. `*RST` is never sent: it would reset the instrument's network settings.
TRIGGER, RELEASE = ":INIT:IMM", ":INIT:CONT ON"
# What a preamble calls them. The four traces share these numbers; what belongs to trace 1 is in the
# lowest bits.
SMOOTHING = ("SMOOTHING_PERCENT", "TRACE_SMOOTHING_PERCENT"), 0xFF
MATH = ("TRACE_MATH_TYPES",), 0xF
# Everything in a preamble that must not change during a survey, and the setting that it is.
WATCHED: Mapping[str, Optional[Command]] = {
    **{name: command for command in SETTINGS for name in command.preamble},
    **dict.fromkeys((*SMOOTHING[0], *MATH[0], "APP_VER", "SUB_MODE")),
}


@dataclass(frozen=True)
class Setting:
    """A command with the value that it must have: what is sent, and what is read back."""

    command: Command
    value: Union[float, str]

    @property
    def sent(self) -> str:
        """The value as it is sent."""
        if self.command is HOLD:
            return "OFF"
        # Twelve digits give any frequency of the instrument to 0.01 Hz without an exponent.
        return self.value if isinstance(self.value, str) else f"{self.value:.12g}"

    def agrees(self, answer: str) -> bool:
        """Return whether an answer to the query means that the value is set."""
        found = self.command.read(answer)
        if isinstance(self.value, str):
            return bool(found == self.value)
        return bool(abs(found - self.value) <= (RESOLUTION_HZ if self.command.unit else 0.0))


Answers = Sequence[Tuple[Setting, str]]


def trace_settings(sweep: SweepSettings, transfer: TransferFormat) -> List[Setting]:
    """Return all settings for one trace of S21 over frequency, in the order in which they are sent.

    Args:
        sweep: What to measure; what it leaves to the instrument is not set.
        transfer: How the numbers are to be transferred.
    """
    wanted: Mapping[Command, Any] = {
        HOLD: False,
        START: sweep.start_frequency_hz,
        STOP: sweep.stop_frequency_hz,
        POINTS: sweep.points,
        TRACES: 1,
        S_PARAMETER: "S21",
        DOMAIN: "FREQ",
        BANDWIDTH: sweep.analyzer.if_bandwidth_hz or None,
        # The driver averages: one of the instrument could hold sweeps from before a move.
        AVERAGES: 1,
        POWER: sweep.analyzer.output_power or None,
        FORMAT: transfer.value,
    }
    return [Setting(command, value) for command, value in wanted.items() if value is not None]


def differing(answers: Answers) -> Answers:
    """Return the settings whose answer means something else."""
    return [(setting, answer) for setting, answer in answers if not setting.agrees(answer)]


def described(answers: Answers) -> Message:
    """Return a sentence on each setting and the answer that differs from it."""
    return in_a_row(
        _differs(
            setting.command.name,
            unquoted(answer),
            f"{setting.sent} {setting.command.unit}".rstrip(),
            setting.command.query,
        )
        for setting, answer in answers
    )


def _differs(setting: Text, found: str, expected: str, details: str) -> Message:
    return Message(
        "{setting} is {found} instead of {expected}",
        setting=setting,
        found=repr(found[:40]),
        expected=expected[:40],
        details=details,
    )


def check_frequencies(reported_hz: np.ndarray, sweep: SweepSettings) -> None:
    """Compare the instrument's list of frequencies [Hz] with the sweep that it confirmed.

    The list itself is not used: in single precision it is wrong by up to 256 Hz.

    Raises:
        VnaDataError: They differ by more than single precision can cause.
    """
    expected_hz = sweep.frequencies_hz()
    if not np.allclose(reported_hz, expected_hz, rtol=SINGLE_PRECISION, atol=RESOLUTION_HZ):
        raise VnaDataError(
            Message(
                "the VNA measures other frequencies than were set; check that it sweeps linearly"
            ),
            fault=VNA_SETTINGS,
        )


class Preamble:
    """What the instrument says of its trace: one answer to `PREAMBLE`."""

    def __init__(self, answer: bytes) -> None:
        """Read an answer.

        Raises:
            VnaDataError: It is not a complete block.
        """
        pairs = (pair.partition("=") for pair in text_block(answer).split(","))
        self._said = {name.strip(): value.strip() for name, _equal, value in pairs}

    def number(self, *names: str) -> Optional[float]:
        """Return the first number of these names, without its unit; None if there is none."""
        for name in names:
            found = _NUMBER.match(self._said.get(name, ""))
            if found:
                return float(found.group())
        return None

    @property
    def temperature_c(self) -> Optional[float]:
        """Temperature of the instrument [degC]; None if it does not say."""
        quarters = self.number("CURRENT_TEMPERATURE")
        if quarters is None or not self.is_corrected:
            return None
        return quarters / QUARTERS_PER_DEGREE

    @property
    def is_corrected(self) -> Optional[bool]:
        """Whether a calibration is applied; None if it does not say."""
        correction = self.number("CAL_CORRECTION")
        return None if correction is None else correction == CORRECTION_ON

    def covers(self, command: Command) -> bool:
        """Return whether it shows every change of a setting."""
        return any(name in self._said for name in command.preamble)

    def check_unprocessed(self) -> None:
        """Do nothing if the trace is what was measured.

        Raises:
            VnaSettingError: It is smoothed, or combined with a memory.
        """
        for name, keys, first in (("smoothing", *SMOOTHING), ("math", *MATH)):
            value = int(self.number(*keys) or 0) & first
            if value:
                raise VnaSettingError(
                    Message(
                        "the VNA processes its trace ({what}); switch smoothing and trace math off",
                        what=f"{name} {value}",
                    )
                )

    def changes(self, now: Preamble) -> Optional[Message]:
        """Return a sentence on everything watched that is different now; None if nothing is.

        Raises:
            VnaReplacedError: The other one is of another instrument.
        """
        former, serial = self._said.get("SN"), now._said.get("SN")
        if former != serial:
            raise replaced(str(serial), str(former))
        changed = [name for name in WATCHED if self._said.get(name) != now._said.get(name)]
        return in_a_row(self._change(name, now) for name in changed) if changed else None

    def _change(self, name: str, now: Preamble) -> Message:
        command = WATCHED[name]
        setting: Text = command.name if command else name
        return _differs(setting, str(now._said.get(name)), str(self._said.get(name)), name)
