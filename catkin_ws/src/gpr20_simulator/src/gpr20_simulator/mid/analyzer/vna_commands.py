"""The documented commands of the simulated analyzer and what each of them does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer import vna_settings as known
from gpr20_simulator.mid.analyzer.instrument_scene import Power
from gpr20_simulator.mid.analyzer.scpi import HeaderPattern, ScpiError
from gpr20_simulator.mid.analyzer.vna_settings import DataFormat, TraceSettings, VnaSettings

Numbers = Tuple[int, ...]
DATA_FORMATS = ("ASCii", "INTeger,32", "REAL,32")
SWEEP_TYPES = ("SINGle", "CONTinuous", "EXTernal")


@dataclass(frozen=True)
class Setting:
    """A header that stores a value, returns it, or both.

    Attributes:
        header: The header as documented.
        reply: Makes the text of the reply; None: cannot be asked.
        store: Changes the settings; None: cannot be set.
    """

    header: HeaderPattern
    reply: Optional[Callable[[VnaSettings, Numbers], str]]
    store: Optional[Callable[[VnaSettings, Numbers, str], None]]


def hertz(value_hz: float) -> str:
    """Return a frequency as the instrument writes it."""
    return f"{value_hz:.0f}" if value_hz.is_integer() else f"{value_hz:.3f}"


def on_off(value: bool) -> str:
    """Return a truth value as the instrument writes it."""
    return "1" if value else "0"


def trace_of(settings: VnaSettings, numbers: Numbers) -> TraceSettings:
    """Return the settings of the trace with the number in the header.

    Raises:
        ScpiError: There is no such trace.
    """
    number = numbers[0]
    if not 1 <= number <= known.TRACES:
        raise ScpiError(f"trace {number} does not exist; there are 1 to {known.TRACES}")
    return settings.traces[number - 1]


def _setting(
    header: str,
    reply: Optional[Callable[[VnaSettings, Numbers], str]],
    store: Optional[Callable[[VnaSettings, Numbers, str], None]],
) -> Setting:
    return Setting(HeaderPattern(header), reply, store)


def _store_start(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.set_start(scpi.frequency_between(text, known.LOWEST_HZ, known.HIGHEST_HZ))


def _store_stop(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.set_stop(scpi.frequency_between(text, known.LOWEST_HZ, known.HIGHEST_HZ))


def _store_centre(settings: VnaSettings, _n: Numbers, text: str) -> None:
    centre_hz = scpi.frequency_between(text, known.LOWEST_HZ, known.HIGHEST_HZ)
    settings.set_centre_and_span(centre_hz, settings.stop_hz - settings.start_hz)


def _store_span(settings: VnaSettings, _n: Numbers, text: str) -> None:
    span_hz = scpi.frequency_between(text, 0.0, known.HIGHEST_HZ - known.LOWEST_HZ)
    settings.set_centre_and_span((settings.start_hz + settings.stop_hz) / 2.0, span_hz)


def _store_points(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.points = scpi.whole_number_between(text, known.FEWEST_POINTS, known.MOST_POINTS)


def _store_bandwidth(settings: VnaSettings, _n: Numbers, text: str) -> None:
    value_hz = scpi.frequency_between(text, known.BANDWIDTHS_HZ[-1], known.BANDWIDTHS_HZ[0])
    if value_hz not in known.BANDWIDTHS_HZ:
        raise ScpiError(f"{value_hz:g} Hz is no bandwidth of this instrument")
    settings.bandwidth_hz = int(value_hz)


def _store_averages(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.averages = scpi.whole_number_between(text, 1, known.MOST_AVERAGES)


def _store_format(settings: VnaSettings, _n: Numbers, text: str) -> None:
    spelled = ",".join(part.strip() for part in text.split(","))
    settings.data_format = DataFormat(scpi.chosen_keyword(spelled, DATA_FORMATS))


def _store_parameter(settings: VnaSettings, numbers: Numbers, text: str) -> None:
    trace_of(settings, numbers).parameter = scpi.chosen_keyword(text, known.PARAMETERS)


def _store_domain(settings: VnaSettings, numbers: Numbers, text: str) -> None:
    trace_of(settings, numbers).domain = scpi.chosen_keyword(text, known.DOMAINS)


def _store_graph_type(settings: VnaSettings, numbers: Numbers, text: str) -> None:
    trace_of(settings, numbers).graph_type = scpi.chosen_keyword(text, known.GRAPH_TYPES)
    settings.active_trace = numbers[0]


def _store_total(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.trace_total = scpi.whole_number_between(text, 1, known.TRACES)


def _select_trace(settings: VnaSettings, numbers: Numbers, _text: str) -> None:
    trace_of(settings, numbers)
    settings.active_trace = numbers[0]


def _store_power(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.power = Power(scpi.chosen_keyword(text, tuple(one.value for one in Power)))


def _store_gain(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.gain = scpi.chosen_keyword(text, ("AUTO", "FIXed"))


def _store_rf(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.rf_on_in_hold = scpi.switch(text)


SETTINGS: Tuple[Setting, ...] = (
    _setting("[:SENSe]:FREQuency:STARt", lambda s, _n: hertz(s.start_hz), _store_start),
    _setting("[:SENSe]:FREQuency:STOP", lambda s, _n: hertz(s.stop_hz), _store_stop),
    _setting(
        "[:SENSe]:FREQuency:CENTer",
        lambda s, _n: hertz((s.start_hz + s.stop_hz) / 2.0),
        _store_centre,
    ),
    _setting("[:SENSe]:FREQuency:SPAN", lambda s, _n: hertz(s.stop_hz - s.start_hz), _store_span),
    _setting("[:SENSe]:SWEep:POINts", lambda s, _n: str(s.points), _store_points),
    _setting("[:SENSe]:SWEep:IFBW", lambda s, _n: str(s.bandwidth_hz), _store_bandwidth),
    _setting("[:SENSe]:AVERage:COUNt", lambda s, _n: str(s.averages), _store_averages),
    _setting("[:SENSe]:TRACe:TOTal", lambda s, _n: str(s.trace_total), _store_total),
    _setting("[:SENSe]:TRACe:SELect", lambda s, _n: f"TR{s.active_trace}", None),
    _setting("[:SENSe]:TRACe#:SELect", None, _select_trace),
    _setting("[:SENSe]:TRACe#:SPARams", lambda s, n: trace_of(s, n).parameter, _store_parameter),
    _setting("[:SENSe]:TRACe#:DOMain", lambda s, n: trace_of(s, n).domain, _store_domain),
    _setting("[:SENSe]:RFON[:STATe]", lambda s, _n: on_off(s.rf_on_in_hold), _store_rf),
    _setting(":CALCulate#:FORMat", lambda s, n: trace_of(s, n).graph_type, _store_graph_type),
    _setting(":FORMat[:READings][:DATA]", lambda s, _n: s.data_format.value, _store_format),
    _setting(":SOURce:POWer", lambda s, _n: s.power.value, _store_power),
    _setting(":INPut:GAIN:MODE", lambda s, _n: s.gain, _store_gain),
)
