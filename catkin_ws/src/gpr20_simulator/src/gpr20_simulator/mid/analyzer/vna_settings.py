"""What can be set on the simulated analyzer: the documented headers and the values it accepts."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Optional, Tuple

from gpr20_simulator.mid.analyzer.sweeper import SweepPlan
from gpr20_simulator.mid.faults import VnaFault

_LEVEL = re.compile(r"(\[?):([A-Za-z]+)(#?)(\]?)")
# No digit can belong to two repetitions, so a long number that is none is refused in linear time.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[Ee][+-]?[0-9]{1,3})?")
LONGEST_NUMBER = 64
_SWITCH = {"ON": True, "1": True, "OFF": False, "0": False}
LOWEST_HZ = 5e3
HIGHEST_HZ = 6e9
MOST_POINTS = 4001
MOST_AVERAGES = 65535
TRACES = 4
POWER_ON_BANDWIDTH_HZ = 10000
# Settling time of a filter times its bandwidth.
SETTLING = 1.4
# Low is -15 to -25 dBm, high +3 to -3 dBm.
LOW_POWER_NOISE_GAIN = 10.0
BANDWIDTHS_HZ = (100000, 50000, 20000, 10000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10)
# In the order of the numbers that a preamble has for them.
PARAMETERS = ("S11", "S21", "S12", "S22")
DOMAINS = ("FREQuency", "TIME", "DISTance", "FGT")
# What somebody sets at the front panel, or else what is there when it is switched on.
OTHER_BANDWIDTH_HZ, OTHER_AVERAGES, MOVED_START_HZ = 1000, 4, 1e6
ASCII, REAL_32 = "ASC", "REAL,32"
DATA_FORMATS = ("ASCii", "REAL,32")
POWERS = LOW, HIGH = ("LOW", "HIGH")

# The numbers in a header.
Numbers = Tuple[int, ...]


class ScpiError(ValueError):
    """A value that the instrument does not accept."""


@dataclass(frozen=True)
class ScpiCommand:
    """One command of a message.

    Attributes:
        header: Keywords with their colons, or a common command with its star.
        is_query: Whether a question mark followed.
        argument: All that came after the header.
    """

    header: str
    is_query: bool
    argument: str


class HeaderPattern:
    """A documented header, such as `[:SENSe]:TRACe#:SPARams`.

    Capitals are the short form, all letters the long one, nothing between is accepted;
    brackets hold what may be left out, and `#` means a number, 1 if it is missing.
    """

    def __init__(self, pattern: str) -> None:
        self.pattern = pattern
        levels = "".join(_level_expression(match) for match in _LEVEL.finditer(pattern))
        self._expression = re.compile(levels or re.escape(pattern), re.IGNORECASE)

    def match(self, header: str) -> Optional[Tuple[int, ...]]:
        """Return the numbers in the header; None if it is another header."""
        found = self._expression.fullmatch(header)
        if found is None:
            return None
        return tuple(1 if number is None else int(number) for number in found.groups())


def _level_expression(match: re.Match[str]) -> str:
    opening, keyword, number, _closing = match.groups()
    expression = ":" + _keyword_expression(keyword) + (r"(\d{1,4})?" if number else "")
    return f"(?:{expression})?" if opening else expression


def _keyword_expression(keyword: str) -> str:
    pieces = re.split(r"([a-z]+)", keyword)
    return "".join(f"(?:{one})?" if one.islower() else re.escape(one) for one in pieces)


def chosen_keyword(text: str, keywords: Tuple[str, ...]) -> str:
    """Return the short form of the keyword that the text spells, one written like `DISTance`.

    Raises:
        ScpiError: It spells none of them.
    """
    for keyword in keywords:
        if re.fullmatch(_keyword_expression(keyword), text.strip(), re.IGNORECASE):
            return "".join(letter for letter in keyword if not letter.islower())
    raise ScpiError(f"'{text[:40]}' is none of {', '.join(keywords)}")


def number_between(text: str, lower: float, upper: float) -> float:
    """Return a number within bounds, in the unit that needs no name.

    Raises:
        ScpiError: It is none, or lies outside.
    """
    word = text.strip()
    if len(word) > LONGEST_NUMBER or not _NUMBER.fullmatch(word):
        raise ScpiError(f"'{text[:40]}' is not a number")
    if not lower <= float(word) <= upper:
        raise ScpiError(f"'{text[:40]}' is not between {lower:g} and {upper:g}")
    return float(word)


def whole_number_between(text: str, lower: int, upper: int) -> int:
    """Return a whole number within bounds; raises as `number_between` does."""
    value = number_between(text, lower, upper)
    if not value.is_integer():
        raise ScpiError(f"'{text[:40]}' is not a whole number")
    return int(value)


def switch(text: str) -> bool:
    """Return whether the text says ON or 1.

    Raises:
        ScpiError: It says neither that nor OFF or 0.
    """
    word = text.strip().upper()
    if word not in _SWITCH:
        raise ScpiError(f"'{text[:40]}' is none of {', '.join(_SWITCH)}")
    return _SWITCH[word]


def split_message(message: bytes) -> List[ScpiCommand]:
    """Return the commands of a message in their order.

    The first header may lack its colon. A later one must have it; the instrument does
    not know what to do with one that lacks it, so it is left out.
    """
    commands = []
    for place, part in enumerate(message.decode("latin-1").strip(" \t\r\n\0").split(";")):
        text = part.strip()
        if place == 0 and text[:1] not in (":", "*"):
            text = ":" + text
        if len(text) > 1 and text[0] in ":*":
            # "DATA?SDAT" has no blank between the question mark and its argument.
            header, *words = text.split(None, 1)
            before, question, after = header.partition("?")
            argument = " ".join(one for one in (after, *words) if one)
            commands.append(ScpiCommand(before, bool(question), argument.strip()))
    return commands


@dataclass
class TraceSettings:
    """One of the four traces; values are short forms."""

    parameter: str
    domain: str = "FREQ"


@dataclass
class VnaSettings:
    """All settings, as they are when the instrument is switched on.

    Attributes:
        start_hz: First frequency [Hz].
        stop_hz: Last frequency [Hz].
        points: Number of frequencies.
        bandwidth_hz: Bandwidth of the intermediate frequency [Hz].
        averages: Number of sweeps that are to be averaged; this model never does.
        data_format: How data are sent, as the instrument calls it.
        trace_total: Number of traces shown.
        traces: The four traces.
        power: Output power of the source.
        is_corrected: Whether the calibration is applied, if there is one.
    """

    start_hz: float = LOWEST_HZ
    stop_hz: float = HIGHEST_HZ
    points: int = 201
    bandwidth_hz: int = POWER_ON_BANDWIDTH_HZ
    averages: int = 1
    data_format: str = ASCII
    trace_total: int = TRACES
    traces: List[TraceSettings] = field(
        default_factory=lambda: [TraceSettings(one) for one in ("S11", "S12", "S21", "S22")]
    )
    power: str = HIGH
    is_corrected: bool = True

    def trace(self, numbers: Numbers) -> TraceSettings:
        """Return the trace with the number in the header.

        Raises:
            ScpiError: There is no such trace.
        """
        (number,) = numbers
        if not 1 <= number <= TRACES:
            raise ScpiError(f"trace {number} does not exist; there are 1 to {TRACES}")
        return self.traces[number - 1]

    def plan(self, seconds_per_point: float) -> SweepPlan:
        """Return the sweep that these settings ask for.

        Args:
            seconds_per_point: Time of a point at the bandwidth of power-on [s]; 0: none at all.
        """
        # Narrower filters take longer to settle.
        longer_s = SETTLING * max(0.0, 1.0 / self.bandwidth_hz - 1.0 / POWER_ON_BANDWIDTH_HZ)
        # The power of noise goes with the bandwidth; less output power leaves it as it is while
        # the signal gets weaker.
        noise_gain = math.sqrt(self.bandwidth_hz / POWER_ON_BANDWIDTH_HZ)
        return SweepPlan(
            self.start_hz,
            self.stop_hz,
            self.points,
            seconds_per_point + longer_s if seconds_per_point > 0.0 else 0.0,
            noise_gain * (LOW_POWER_NOISE_GAIN if self.power == LOW else 1.0),
        )


@dataclass(frozen=True)
class Setting:
    """A header with what it answers and what it changes.

    Attributes:
        header: The header as documented.
        reply: Makes the text of the reply.
        store: Changes the settings, or raises ScpiError.
        is_calibrated: Whether an instrument with the fault LOSES_CALIBRATION loses it by this.
    """

    header: HeaderPattern
    reply: Callable[[VnaSettings, Numbers], str]
    store: Callable[[VnaSettings, Numbers, str], None]
    is_calibrated: bool = False


def hertz(value_hz: float) -> str:
    """Return a frequency as the instrument writes it."""
    return f"{value_hz:.0f}" if value_hz.is_integer() else f"{value_hz:.3f}"


def _store_start(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.start_hz = number_between(text, LOWEST_HZ, HIGHEST_HZ)
    settings.stop_hz = max(settings.start_hz, settings.stop_hz)


def _store_stop(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.stop_hz = number_between(text, LOWEST_HZ, HIGHEST_HZ)
    settings.start_hz = min(settings.start_hz, settings.stop_hz)


def _bandwidth_hz(text: str) -> int:
    value_hz = number_between(text, BANDWIDTHS_HZ[-1], BANDWIDTHS_HZ[0])
    if value_hz not in BANDWIDTHS_HZ:
        raise ScpiError(f"{value_hz:g} Hz is no bandwidth of this instrument")
    return int(value_hz)


def _data_format(text: str) -> str:
    spelled = ",".join(part.strip() for part in text.split(","))
    return chosen_keyword(spelled, DATA_FORMATS)


def _whole_number(lower: int, upper: int) -> Callable[[str], int]:
    return lambda text: whole_number_between(text, lower, upper)


def _own(
    header: str, name: str, read: Callable[[str], object], is_calibrated: bool = False
) -> Setting:
    """Return the setting that is this attribute of the instrument's."""
    return Setting(
        HeaderPattern(header),
        lambda settings, _n: str(getattr(settings, name)),
        lambda settings, _n, text: setattr(settings, name, read(text)),
        is_calibrated,
    )


def _of_trace(header: str, name: str, keywords: Tuple[str, ...]) -> Setting:
    """Return the setting that is this attribute of the trace's."""
    return Setting(
        HeaderPattern(header),
        lambda settings, n: str(getattr(settings.trace(n), name)),
        lambda settings, n, text: setattr(settings.trace(n), name, chosen_keyword(text, keywords)),
    )


START, STOP = (HeaderPattern(f"[:SENSe]:FREQuency:{end}") for end in ("STARt", "STOP"))
SETTINGS: Tuple[Setting, ...] = (
    Setting(START, lambda settings, _n: hertz(settings.start_hz), _store_start, True),
    Setting(STOP, lambda settings, _n: hertz(settings.stop_hz), _store_stop, True),
    _own("[:SENSe]:SWEep:POINts", "points", _whole_number(2, MOST_POINTS), True),
    _own("[:SENSe]:SWEep:IFBW", "bandwidth_hz", _bandwidth_hz, True),
    _own(":SOURce:POWer", "power", lambda text: chosen_keyword(text, POWERS), True),
    _own("[:SENSe]:AVERage:COUNt", "averages", _whole_number(1, MOST_AVERAGES)),
    _own("[:SENSe]:TRACe:TOTal", "trace_total", _whole_number(1, TRACES)),
    _of_trace("[:SENSe]:TRACe#:SPARams", "parameter", PARAMETERS),
    _of_trace("[:SENSe]:TRACe#:DOMain", "domain", DOMAINS),
    _own("[:SENSe]:CORRection[:STATe]", "is_corrected", switch),
    _own(":FORMat[:READings][:DATA]", "data_format", _data_format),
)


# What somebody may change at the front panel in the middle of a sweep.
Change = Callable[[VnaSettings], None]


def _change_bandwidth(settings: VnaSettings) -> None:
    is_other = settings.bandwidth_hz == OTHER_BANDWIDTH_HZ
    settings.bandwidth_hz = POWER_ON_BANDWIDTH_HZ if is_other else OTHER_BANDWIDTH_HZ


def _change_averages(settings: VnaSettings) -> None:
    settings.averages = 1 if settings.averages == OTHER_AVERAGES else OTHER_AVERAGES


def _change_power(settings: VnaSettings) -> None:
    settings.power = LOW if settings.power == HIGH else HIGH


def _change_start(settings: VnaSettings) -> None:
    settings.start_hz += MOVED_START_HZ
    settings.stop_hz = max(settings.start_hz, settings.stop_hz)


CHANGES_BY_HAND: Dict[VnaFault, Change] = {
    VnaFault.HAND_BANDWIDTH: _change_bandwidth,
    VnaFault.HAND_AVERAGES: _change_averages,
    VnaFault.HAND_POWER: _change_power,
    VnaFault.HAND_START: _change_start,
}
