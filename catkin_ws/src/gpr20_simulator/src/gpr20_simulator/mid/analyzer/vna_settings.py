"""What can be set on the simulated analyzer, and the values it accepts."""

from __future__ import annotations

import enum
import math
from collections import deque
from dataclasses import dataclass, field
from typing import Callable, Deque, List, Tuple

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.instrument_scene import Averaging, Power
from gpr20_simulator.mid.analyzer.sweep_plan import SweepPlan

LOWEST_HZ = 5e3
HIGHEST_HZ = 6e9
FEWEST_POINTS = 2
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
GRAPH_TYPES = (
    "LMAGnitude",
    "SWR",
    "PHASe",
    "REAL",
    "IMAGinary",
    "GDELay",
    "SMITh",
    "ISMith",
    "LM/2",
    "LINPolar",
    "LOGPolar",
    "RIMPedance",
    "IIMPedance",
)


class DataFormat(enum.Enum):
    """How numbers are sent; the values are what the instrument calls them."""

    ASCII = "ASC"
    INTEGER_32 = "INT,32"
    REAL_32 = "REAL,32"


@dataclass
class TraceSettings:
    """One of the four traces; values are short forms."""

    parameter: str
    graph_type: str
    domain: str = "FREQ"


def _power_on_traces() -> List[TraceSettings]:
    return [
        TraceSettings("S11", "SMIT"),
        TraceSettings("S12", "LMAG"),
        TraceSettings("S21", "LMAG"),
        TraceSettings("S22", "SMIT"),
    ]


@dataclass
class VnaSettings:
    """All settings, as they are when the instrument is switched on.

    Attributes:
        start_hz: First frequency [Hz].
        stop_hz: Last frequency [Hz].
        points: Number of frequencies.
        bandwidth_hz: Bandwidth of the intermediate frequency [Hz].
        averages: Number of sweeps that are averaged; 1: none.
        data_format: How data are sent.
        is_external: Whether sweeps wait for an external trigger.
        trace_total: Number of traces shown.
        active_trace: Number of the active trace.
        traces: The four traces.
        power: Output power of the source.
        gain: AUTO or FIX.
        rf_on_in_hold: Whether the source stays on while held.
        is_corrected: Whether the calibration is applied.
    """

    start_hz: float = LOWEST_HZ
    stop_hz: float = HIGHEST_HZ
    points: int = 201
    bandwidth_hz: int = POWER_ON_BANDWIDTH_HZ
    averages: int = 1
    data_format: DataFormat = DataFormat.ASCII
    is_external: bool = False
    trace_total: int = TRACES
    active_trace: int = 1
    traces: List[TraceSettings] = field(default_factory=_power_on_traces)
    power: Power = Power.HIGH
    gain: str = "AUTO"
    rf_on_in_hold: bool = True
    is_corrected: bool = False

    def set_start(self, start_hz: float) -> None:
        """Move the first frequency; the last one gives way."""
        self.start_hz, self.stop_hz = start_hz, max(start_hz, self.stop_hz)

    def set_stop(self, stop_hz: float) -> None:
        """Move the last frequency; the first one gives way."""
        self.start_hz, self.stop_hz = min(self.start_hz, stop_hz), stop_hz

    def set_centre_and_span(self, centre_hz: float, span_hz: float) -> None:
        """Set both ends by centre and span; the span is cut where the range ends."""
        half_hz = min(span_hz / 2.0, centre_hz - LOWEST_HZ, HIGHEST_HZ - centre_hz)
        self.start_hz, self.stop_hz = centre_hz - half_hz, centre_hz + half_hz

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
        point_s = seconds_per_point + longer_s if seconds_per_point > 0.0 else 0.0
        return SweepPlan(
            self.start_hz,
            self.stop_hz,
            self.points,
            point_s,
            self.averages,
            averaging is Averaging.ALL_SWEEPS,
            self._noise_gain(),
        )

    def _noise_gain(self) -> float:
        """Return the noise of S21 relative to that of the settings of power-on."""
        # The power of noise goes with the bandwidth; less output power leaves it as it is while
        # the signal gets weaker.
        bandwidth_gain = math.sqrt(self.bandwidth_hz / POWER_ON_BANDWIDTH_HZ)
        return bandwidth_gain * (LOW_POWER_NOISE_GAIN if self.power is Power.LOW else 1.0)


class SettingQueue:
    """Keeps settings back, as the instrument may do for up to two seconds.

    Args:
        clock: Tells the time.
        delay_s: How long each setting takes [s]; 0: none at all.
    """

    def __init__(self, clock: Clock, delay_s: float) -> None:
        self._clock = clock
        self._delay_s = delay_s
        self._waiting: Deque[Tuple[float, Callable[[], None]]] = deque()

    def put(self, apply: Callable[[], None]) -> None:
        """Take a setting; without a delay it takes effect now."""
        self._waiting.append((self._clock.now_s() + self._delay_s, apply))
        self.apply_due()

    def apply_due(self) -> None:
        """Let those settings take effect whose time has come, in their order."""
        while self._waiting and self._waiting[0][0] <= self._clock.now_s():
            _due_s, apply = self._waiting.popleft()
            apply()

    def clear(self) -> None:
        """Forget what has not taken effect."""
        self._waiting.clear()
