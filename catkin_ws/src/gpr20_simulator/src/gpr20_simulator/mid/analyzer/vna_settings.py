"""What can be set on the simulated analyzer: the documented headers and the values it accepts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Tuple

from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer.instrument_scene import Averaging, Power
from gpr20_simulator.mid.analyzer.scpi import HeaderPattern, ScpiError
from gpr20_simulator.mid.analyzer.sweeper import SweepPlan
from gpr20_simulator.mid.faults import VnaFault

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

# The numbers in a header.
Numbers = Tuple[int, ...]


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
        averages: Number of sweeps that are averaged; 1: none.
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
    power: Power = Power.HIGH
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

    def plan(
        self, seconds_per_point: float, averaging: Averaging = Averaging.EACH_SWEEP
    ) -> SweepPlan:
        """Return the sweep that these settings ask for.

        Args:
            seconds_per_point: Time of a point at the bandwidth of power-on [s]; 0: none at all.
            averaging: When a triggered sweep with averaging is complete.
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
            self.averages,
            averaging is Averaging.ALL_SWEEPS,
            noise_gain * (LOW_POWER_NOISE_GAIN if self.power is Power.LOW else 1.0),
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
    settings.start_hz = scpi.frequency_between(text, LOWEST_HZ, HIGHEST_HZ)
    settings.stop_hz = max(settings.start_hz, settings.stop_hz)


def _store_stop(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.stop_hz = scpi.frequency_between(text, LOWEST_HZ, HIGHEST_HZ)
    settings.start_hz = min(settings.start_hz, settings.stop_hz)


def _store_points(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.points = scpi.whole_number_between(text, 2, MOST_POINTS)


def _store_bandwidth(settings: VnaSettings, _n: Numbers, text: str) -> None:
    value_hz = scpi.frequency_between(text, BANDWIDTHS_HZ[-1], BANDWIDTHS_HZ[0])
    if value_hz not in BANDWIDTHS_HZ:
        raise ScpiError(f"{value_hz:g} Hz is no bandwidth of this instrument")
    settings.bandwidth_hz = int(value_hz)


def _store_averages(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.averages = scpi.whole_number_between(text, 1, MOST_AVERAGES)


def _store_total(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.trace_total = scpi.whole_number_between(text, 1, TRACES)


def _store_parameter(settings: VnaSettings, numbers: Numbers, text: str) -> None:
    settings.trace(numbers).parameter = scpi.chosen_keyword(text, PARAMETERS)


def _store_domain(settings: VnaSettings, numbers: Numbers, text: str) -> None:
    settings.trace(numbers).domain = scpi.chosen_keyword(text, DOMAINS)


def _store_format(settings: VnaSettings, _n: Numbers, text: str) -> None:
    spelled = ",".join(part.strip() for part in text.split(","))
    settings.data_format = scpi.chosen_keyword(spelled, DATA_FORMATS)


def _store_correction(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.is_corrected = scpi.switch(text)


def _store_power(settings: VnaSettings, _n: Numbers, text: str) -> None:
    settings.power = Power(scpi.chosen_keyword(text, tuple(one.value for one in Power)))


def _setting(
    header: str,
    reply: Callable[[VnaSettings, Numbers], str],
    store: Callable[[VnaSettings, Numbers, str], None],
    is_calibrated: bool = False,
) -> Setting:
    return Setting(HeaderPattern(header), reply, store, is_calibrated)


SETTINGS: Tuple[Setting, ...] = (
    _setting("[:SENSe]:FREQuency:STARt", lambda s, _n: hertz(s.start_hz), _store_start, True),
    _setting("[:SENSe]:FREQuency:STOP", lambda s, _n: hertz(s.stop_hz), _store_stop, True),
    _setting("[:SENSe]:SWEep:POINts", lambda s, _n: str(s.points), _store_points, True),
    _setting("[:SENSe]:SWEep:IFBW", lambda s, _n: str(s.bandwidth_hz), _store_bandwidth, True),
    _setting(":SOURce:POWer", lambda s, _n: s.power.value, _store_power, True),
    _setting("[:SENSe]:AVERage:COUNt", lambda s, _n: str(s.averages), _store_averages),
    _setting("[:SENSe]:TRACe:TOTal", lambda s, _n: str(s.trace_total), _store_total),
    _setting("[:SENSe]:TRACe#:SPARams", lambda s, n: s.trace(n).parameter, _store_parameter),
    _setting("[:SENSe]:TRACe#:DOMain", lambda s, n: s.trace(n).domain, _store_domain),
    _setting("[:SENSe]:CORRection[:STATe]", lambda s, _n: "01"[s.is_corrected], _store_correction),
    _setting(":FORMat[:READings][:DATA]", lambda s, _n: s.data_format, _store_format),
)


# What somebody may change at the front panel in the middle of a sweep.
Change = Callable[[VnaSettings], None]


def _change_bandwidth(settings: VnaSettings) -> None:
    is_other = settings.bandwidth_hz == OTHER_BANDWIDTH_HZ
    settings.bandwidth_hz = POWER_ON_BANDWIDTH_HZ if is_other else OTHER_BANDWIDTH_HZ


def _change_averages(settings: VnaSettings) -> None:
    settings.averages = 1 if settings.averages == OTHER_AVERAGES else OTHER_AVERAGES


def _change_power(settings: VnaSettings) -> None:
    settings.power = Power.LOW if settings.power is Power.HIGH else Power.HIGH


def _change_start(settings: VnaSettings) -> None:
    has_room = settings.start_hz + MOVED_START_HZ <= HIGHEST_HZ
    settings.start_hz += MOVED_START_HZ if has_room else -MOVED_START_HZ
    settings.stop_hz = max(settings.start_hz, settings.stop_hz)


CHANGES_BY_HAND: Dict[VnaFault, List[Change]] = {
    VnaFault.HAND_BANDWIDTH: [_change_bandwidth],
    VnaFault.HAND_AVERAGES: [_change_averages],
    VnaFault.HAND_POWER: [_change_power],
    VnaFault.HAND_START: [_change_start],
    # The other bandwidth, and the one of before.
    VnaFault.HAND_PUT_BACK: [_change_bandwidth, _change_bandwidth],
}
