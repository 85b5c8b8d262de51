"""The instrument's settings that a survey needs: command, query, and how to compare.

The spellings are those of the MS20xxC programming manual, chapter 3. It has no error
queue: reading back is the only way to know whether a setting was taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, List

import numpy as np

from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.block_parser import TransferFormat, number

# The instrument may round to the resolution of its synthesizer.
RESOLUTION_HZ = 1.0
# Frequencies may have travelled in single precision, rounded once by it and once by us.
SINGLE_PRECISION_STEPS = 2.0


@dataclass(frozen=True)
class Setting:
    """One setting with the value it shall have.

    Attributes:
        name: What it is, for people.
        header: The command without value; with a question mark it is the query.
        value: What is sent behind the header.
        agrees: Whether an answer to the query says that the value is set.
    """

    name: str
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
    """Return a text answer without the quotation marks that some come in."""
    return answer.strip().strip('"').strip()


def _word(name: str, header: str, value: str, answer: str = "") -> Setting:
    expected = answer or value
    return Setting(name, header, value, lambda text: unquoted(text).upper() == expected)


def _count(name: str, header: str, value: int) -> Setting:
    return Setting(name, header, str(value), lambda text: number(text) == value)


def _frequency(name: str, header: str, value_hz: float) -> Setting:
    # Twelve digits hold any frequency of the instrument to 0.01 Hz without an exponent.
    return Setting(
        name, header, f"{value_hz:.12g}", lambda text: abs(number(text) - value_hz) <= RESOLUTION_HZ
    )


# In hold, nothing sweeps until it is triggered. `INIT:CONT?` answers 0 in hold.
HOLD = _word("hold", ":INIT:CONT", "OFF", answer="0")
S21 = _word("S-parameter of trace 1", ":SENS:TRACE1:SPAR", "S21")
FREQUENCY_DOMAIN = _word("domain of trace 1", ":SENS:TRACE1:DOM", "FREQ")
# An average would mix sweeps taken before and after a move.
NO_AVERAGE = _count("number of averages", ":SENS:AVER:COUN", 1)


def frequency_settings(sweep: SweepSettings) -> List[Setting]:
    """Return what is set to measure these frequencies, in the order in which it is sent."""
    return [
        HOLD,
        _frequency("start frequency", ":SENS:FREQ:STAR", sweep.start_frequency_hz),
        _frequency("stop frequency", ":SENS:FREQ:STOP", sweep.stop_frequency_hz),
        _count("number of points", ":SENS:SWE:POIN", sweep.points),
    ]


def trace_settings(transfer: TransferFormat, has_time_domain: bool) -> List[Setting]:
    """Return what is set to get one trace of S21 over frequency.

    Args:
        transfer: How the numbers shall travel.
        has_time_domain: Whether the instrument has the option that transforms traces.
    """
    return [
        # More traces on the display could only make the sweep slower.
        _count("number of traces", ":SENS:TRAC:TOT", 1),
        S21,
        *_domain(has_time_domain),
        NO_AVERAGE,
        _word("transfer format", ":FORM", transfer.value),
    ]


def watched_settings(sweep: SweepSettings, has_time_domain: bool) -> List[Setting]:
    """Return what is looked at after each sweep: a hand at the instrument may change it.

    A changed number of points or transfer format shows in the data themselves.
    """
    *frequencies, _points = frequency_settings(sweep)
    return [*frequencies, S21, *_domain(has_time_domain), NO_AVERAGE]


def check_frequencies(reported_hz: np.ndarray, sweep: SweepSettings) -> None:
    """Compare the instrument's own list with ours.

    The list is not used itself: in single precision it is wrong by up to 256 Hz.

    Args:
        reported_hz: The list the instrument gives [Hz].
        sweep: The sweep that it confirmed.

    Raises:
        VnaDataError: They differ by more than single precision explains.
    """
    expected_hz = sweep.frequencies_hz()
    spacing_hz = np.spacing(expected_hz.astype(np.float32)).astype(np.float64)
    tolerance_hz = SINGLE_PRECISION_STEPS * spacing_hz + RESOLUTION_HZ
    wrong = np.abs(reported_hz - expected_hz) > tolerance_hz
    if wrong.any():
        first = int(np.argmax(wrong))
        raise VnaDataError(
            f"the instrument measures {reported_hz[first]:.12g} Hz at point {first}, where "
            f"{expected_hz[first]:.12g} Hz follow from start, stop and points; "
            "check that it sweeps linearly"
        )


def _domain(has_time_domain: bool) -> List[Setting]:
    # Without the option the instrument does not know the command and would not answer.
    return [FREQUENCY_DOMAIN] if has_time_domain else []
