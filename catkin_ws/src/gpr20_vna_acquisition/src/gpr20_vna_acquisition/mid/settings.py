"""The instrument's settings that a survey needs: command, query, and how to compare.

The spellings are those of the MS20xxC programming manual, chapter 3. The instrument has no
error queue: reading back is the only way to know whether it accepted a setting.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, List

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep_settings import SweepSettings
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
    """

    name: Message
    header: str
    value: str
    agrees: Callable[[str], bool]

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


def _word(name: Message, header: str, value: str, answer: str = "") -> Setting:
    expected = answer or value
    return Setting(name, header, value, lambda text: unquoted(text).upper() == expected)


def _count(name: Message, header: str, value: int) -> Setting:
    return Setting(name, header, str(value), lambda text: number(text) == value)


def _frequency(name: Message, header: str, value_hz: float) -> Setting:
    # Twelve digits give any frequency of the instrument to 0.01 Hz without an exponent.
    return Setting(
        name, header, f"{value_hz:.12g}", lambda text: abs(number(text) - value_hz) <= RESOLUTION_HZ
    )


# In hold, the instrument sweeps only when triggered. `INIT:CONT?` answers 0 in hold.
HOLD = _word(Message("continuous sweep"), ":INIT:CONT", "OFF", answer="0")
S21 = _word(Message("the S-parameter of trace 1"), ":SENS:TRACE1:SPAR", "S21")
FREQUENCY_DOMAIN = _word(Message("the domain of trace 1"), ":SENS:TRACE1:DOM", "FREQ")
# An average would mix sweeps from before and after a move.
NO_AVERAGE = _count(Message("the number of averages"), ":SENS:AVER:COUN", 1)


def frequency_settings(sweep: SweepSettings) -> List[Setting]:
    """Return the settings for measuring these frequencies, in the order in which they are sent."""
    return [
        HOLD,
        _frequency(Message("the start frequency"), ":SENS:FREQ:STAR", sweep.start_frequency_hz),
        _frequency(Message("the stop frequency"), ":SENS:FREQ:STOP", sweep.stop_frequency_hz),
        _count(Message("the number of points"), ":SENS:SWE:POIN", sweep.points),
    ]


def trace_settings(transfer: TransferFormat, has_time_domain: bool) -> List[Setting]:
    """Return the settings for one trace of S21 over frequency.

    Args:
        transfer: How the numbers are to be transferred.
        has_time_domain: Whether the instrument has the option that transforms traces.
    """
    return [
        # More traces on the display could only make the sweep slower.
        _count(Message("the number of traces"), ":SENS:TRAC:TOT", 1),
        S21,
        *_domain(has_time_domain),
        NO_AVERAGE,
        _word(Message("the transfer format"), ":FORM", transfer.value),
    ]


def watched_settings(sweep: SweepSettings, has_time_domain: bool) -> List[Setting]:
    """Return the settings that are checked after each sweep: an operator may change them.

    A changed number of points or transfer format is visible in the data themselves.
    """
    *frequencies, _points = frequency_settings(sweep)
    return [*frequencies, S21, *_domain(has_time_domain), NO_AVERAGE]


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
            )
        )


def _domain(has_time_domain: bool) -> List[Setting]:
    # Without the option the instrument does not know the command and would not answer.
    return [FREQUENCY_DOMAIN] if has_time_domain else []
