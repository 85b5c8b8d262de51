"""The instrument's settings that a survey needs: command, query, and how to compare.

The spellings are those of the MS20xxC programming manual, chapter 3. The instrument has no
error queue: reading back is the only way to know whether it accepted a setting.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, List, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message, in_a_row
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.block_parser import TransferFormat, number

# The instrument may round to the resolution of its synthesizer.
RESOLUTION_HZ = 1.0
# Frequencies may be in single precision, rounded once by the instrument and once here.
SINGLE_PRECISION_STEPS = 2.0


@dataclass(frozen=True)
class Setting:
    """One setting with its required value.

    Attributes:
        name: What is set.
        header: The command without value; with a question mark it is the query.
        value: What is sent after the header.
        agrees: Whether an answer to the query means that the value is set.
        required: Whether the data depend on it. If not, the instrument need not answer the query.
        unit: Unit of the value, for people.
    """

    name: Message
    header: str
    value: str
    agrees: Callable[[str], bool]
    required: bool = True
    unit: str = ""

    @property
    def command(self) -> str:
        """The command that makes the setting."""
        return f"{self.header} {self.value}"

    @property
    def query(self) -> str:
        """The query that reads it back."""
        return f"{self.header}?"


def unquoted(answer: str) -> str:
    """Return a text answer without the quotation marks that some answers have."""
    return answer.strip().strip('"').strip()


def number_setting(name: Message, header: str, value: float) -> Setting:
    """Return a setting with a number that the instrument has exactly."""
    return Setting(name, header, f"{value:g}", lambda text: number(text) == value)


def word_setting(
    name: Message, header: str, value: str, answer: str = "", required: bool = True
) -> Setting:
    """Return a setting with a word; `answer` is its short form, if that is another word."""
    expected = answer or value
    return Setting(name, header, value, lambda text: unquoted(text).upper() == expected, required)


def _frequency(name: Message, header: str, value_hz: float) -> Setting:
    # Twelve digits give any frequency of the instrument to 0.01 Hz without an exponent.
    return Setting(
        name,
        header,
        f"{value_hz:.12g}",
        lambda text: abs(number(text) - value_hz) <= RESOLUTION_HZ,
        unit="Hz",
    )


TRANSFER_FORMAT = ":FORM"
IF_BANDWIDTH, IF_BANDWIDTH_QUERY = Message("the IF bandwidth"), ":SENS:SWE:IFBW?"
AVERAGES, AVERAGES_QUERY = Message("the number of averages"), ":SENS:AVER:COUN?"
OUTPUT_POWER, POWER_QUERY = Message("the output power"), ":SOUR:POW?"
START, STOP, POINTS = FREQUENCY_HEADERS = (
    ":SENS:FREQ:STAR",
    ":SENS:FREQ:STOP",
    ":SENS:SWE:POIN",
)

# In hold, the instrument sweeps only when triggered. `INIT:CONT?` answers 0 in hold.
HOLD = word_setting(Message("continuous sweep"), ":INIT:CONT", "OFF", answer="0")
S21 = word_setting(Message("the S-parameter of trace 1"), ":SENS:TRACE1:SPAR", "S21")
FREQUENCY_DOMAIN = word_setting(
    Message("the domain of trace 1"), ":SENS:TRACE1:DOM", "FREQ", required=False
)
# More traces on the display could only make the sweep slower.
ONE_TRACE = replace(
    number_setting(Message("the number of traces"), ":SENS:TRAC:TOT", 1), required=False
)


def trace_settings(
    sweep: SweepSettings, transfer: TransferFormat, has_time_domain: bool
) -> List[Setting]:
    """Return all settings for one trace of S21 over frequency, in the order in which they are sent.

    Args:
        sweep: What to measure; what it leaves to the instrument is not set.
        transfer: How the numbers are to be transferred.
        has_time_domain: Whether the instrument has the option that transforms traces.
    """
    return [
        HOLD,
        _frequency(Message("the start frequency"), START, sweep.start_frequency_hz),
        _frequency(Message("the stop frequency"), STOP, sweep.stop_frequency_hz),
        number_setting(Message("the number of points"), POINTS, sweep.points),
        ONE_TRACE,
        S21,
        # Without the option the instrument does not know the command and would not answer.
        *([FREQUENCY_DOMAIN] if has_time_domain else []),
        *_analyzer_settings(sweep.analyzer),
        word_setting(Message("the transfer format"), TRANSFER_FORMAT, transfer.value),
    ]


def _analyzer_settings(wanted: AnalyzerSettings) -> List[Setting]:
    found = []
    if wanted.if_bandwidth_hz:
        header = _header(IF_BANDWIDTH_QUERY)
        bandwidth = number_setting(IF_BANDWIDTH, header, wanted.if_bandwidth_hz)
        found.append(replace(bandwidth, unit="Hz"))
    if wanted.averages:
        found.append(number_setting(AVERAGES, _header(AVERAGES_QUERY), wanted.averages))
    if wanted.output_power:
        found.append(word_setting(OUTPUT_POWER, _header(POWER_QUERY), wanted.output_power))
    return found


def check_frequencies(reported_hz: np.ndarray, sweep: SweepSettings) -> None:
    """Compare the instrument's list of frequencies with the confirmed sweep.

    The list itself is not used: in single precision it is wrong by up to 256 Hz.

    Args:
        reported_hz: The instrument's list [Hz].
        sweep: The sweep that it confirmed.

    Raises:
        VnaDataError: They differ by more than single precision can cause.
    """
    expected_hz = sweep.frequencies_hz()
    spacing_hz = np.spacing(expected_hz.astype(np.float32)).astype(np.float64)
    tolerance_hz = SINGLE_PRECISION_STEPS * spacing_hz + RESOLUTION_HZ
    wrong = np.abs(reported_hz - expected_hz) > tolerance_hz
    if wrong.any():
        first = int(np.argmax(wrong))
        raise VnaDataError(
            Message(
                "the VNA measures {reported_hz:.12g} Hz at point {point} instead of "
                "{expected_hz:.12g} Hz; check that it sweeps linearly",
                reported_hz=reported_hz[first],
                point=first,
                expected_hz=expected_hz[first],
            ),
            fault=VNA_SETTINGS,
        )


def described(differing: Sequence[Tuple[Setting, str]]) -> Message:
    """Return a sentence on each setting and the answer that differs from it."""
    return in_a_row(
        Message(
            "{setting} is {found} instead of {expected}",
            setting=setting.name,
            found=repr(unquoted(answer)[:40]),
            expected=f"{setting.value} {setting.unit}".rstrip(),
            details=f"{setting.query} answers {answer[:40]!r}",
        )
        for setting, answer in differing
    )


def _header(query: str) -> str:
    return query[:-1]
