"""What a sweep covers, how it is measured, and the frequencies that follow from it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gpr20_common.message import Message
from gpr20_common.mid.checks import with_unit
from gpr20_survey import faults
from gpr20_survey.trace import trace_form as forms

# Far beyond what any analyzer has.
MAX_IF_BANDWIDTH_HZ = 1.0e9
MAX_AVERAGES = 1_000_000
_BANDWIDTH = forms.between(0.0, MAX_IF_BANDWIDTH_HZ, faults.VNA_FAILED)
_AVERAGES = forms.between(0, MAX_AVERAGES, faults.VNA_FAILED)
_POWER = forms.printable(32, faults.VNA_FAILED)


@dataclass(frozen=True)
class AnalyzerSettings:
    """How the analyzer measures.

    In a request, 0 or an empty text leaves the instrument's own value; in an answer or a record
    it means that the value is not known.
    """

    if_bandwidth_hz: float = forms.of(
        forms.FLOAT64, "bandwidth of the receiver, as read back", "Hz", 0.0, _BANDWIDTH, 0.0
    )
    averages: int = forms.of(
        forms.INT32, "sweeps averaged for the trace, as read back", "", 0, _AVERAGES, default=0
    )
    output_power: str = forms.of(
        forms.TEXT, "as read back; `LOW` or `HIGH` for the MS2026C", "", "", _POWER, default=""
    )

    @property
    def message(self) -> Message:
        unknown, hertz = Message("unknown"), self.if_bandwidth_hz
        return Message(
            "IF bandwidth {bandwidth}, averages {averages}, output power {power}",
            bandwidth=with_unit(hertz, "Hz") if hertz else unknown,
            averages=self.averages or unknown,
            power=self.output_power or unknown,
        )

    def fulfils(self, wanted: AnalyzerSettings) -> bool:
        """Return whether these settings, as read back, are the wanted ones.

        What `wanted` leaves to the instrument may have any value here.
        """
        return (
            wanted.if_bandwidth_hz in (0.0, self.if_bandwidth_hz)
            and wanted.averages in (0, self.averages)
            and wanted.output_power in ("", self.output_power)
        )


@dataclass(frozen=True)
class SweepSettings:
    """Start and stop frequency [Hz], both measured, the number of points, and how to measure."""

    start_frequency_hz: float
    stop_frequency_hz: float
    points: int
    analyzer: AnalyzerSettings = AnalyzerSettings()

    def frequencies_hz(self) -> np.ndarray:
        return np.linspace(self.start_frequency_hz, self.stop_frequency_hz, self.points)

    def fulfils(self, wanted: SweepSettings) -> bool:
        is_fulfilled = self.analyzer.fulfils(wanted.analyzer)
        return is_fulfilled and replace(self, analyzer=wanted.analyzer) == wanted
