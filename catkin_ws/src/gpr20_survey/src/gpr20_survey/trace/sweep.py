"""One S21 sweep, checked, and the settings with which an analyzer makes it."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from typing import Iterator, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_common.mid.checks import with_unit
from gpr20_survey import faults
from gpr20_survey.trace import trace_form as forms
from gpr20_survey.trace import utc_time

# Far beyond what any analyzer has.
MAX_IF_BANDWIDTH_HZ = 1.0e9
_MOST_AVERAGES = 1_000_000
_BANDWIDTH = forms.between(0.0, MAX_IF_BANDWIDTH_HZ, faults.VNA_FAILED)
_AVERAGES = forms.between(0, _MOST_AVERAGES, faults.VNA_FAILED)
_POWER = forms.printable(32, faults.VNA_FAILED)
MIN_POINTS, MAX_POINTS = 2, 4001
MAX_REMARKS, MAX_REMARK_CHARACTERS = 32, 200
_REMARK = forms.printable(MAX_REMARK_CHARACTERS)
_REMARKS = forms.Rule(
    lambda remarks: len(remarks) <= MAX_REMARKS and all(map(_REMARK.holds, remarks)),
    Message(
        "at most {most} remarks, each printable and of at most {characters} characters",
        most=MAX_REMARKS,
        characters=MAX_REMARK_CHARACTERS,
    ),
)


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


class CalibrationStatus(enum.IntEnum):
    """The calibration by the scale of the MS2026C; its order is not one of quality.

    NOT_REPORTED is not on that scale: the analyzer does not say how good its calibration is, or
    whether it has one.
    """

    NONE = 0
    HIGH = 1
    MODERATE_POWER = 2
    MODERATE_TEMPERATURE = 3
    LOW = 4
    NOT_REPORTED = 5

    @property
    def meaning(self) -> Message:
        return {
            CalibrationStatus.NONE: Message("no calibration"),
            CalibrationStatus.HIGH: Message("calibrated, accuracy high"),
            CalibrationStatus.MODERATE_POWER: Message(
                "moderate, power level changed since calibration"
            ),
            CalibrationStatus.MODERATE_TEMPERATURE: Message(
                "moderate, temperature changed by more than 5 degrees since calibration"
            ),
            CalibrationStatus.LOW: Message(
                "low, temperature changed by more than 10 degrees since calibration"
            ),
            CalibrationStatus.NOT_REPORTED: Message("not reported by this analyzer"),
        }[self]


# Of an MS2026C: [SENSe]:FREQuency:STARt
MIN_FREQUENCY_HZ = 5.0e3
MAX_FREQUENCY_HZ = 6.0e9
MIN_FREQUENCY_POINTS = 2
MAX_FREQUENCY_POINTS = 4000
# Closer frequencies could be one to the synthesizer.
MIN_FREQUENCY_SPACING_HZ = 1.0
# [SENSe]:SWEep:IFBW
IF_BANDWIDTHS_HZ = (
    *(10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0),
    *(10_000.0, 20_000.0, 50_000.0, 100_000.0),
)
MAX_AVERAGES = 65_535
# :SOURce:POWer
OUTPUT_POWERS = ("LOW", "HIGH")
# What the robot's group states for its unit, at the IF bandwidth that it usually has.
SECONDS_PER_POINT = 350.0e-6
USUAL_IF_BANDWIDTH_HZ = 10_000.0


def sweep_duration_s(
    sweep: SweepSettings,
    seconds_per_point: float = SECONDS_PER_POINT,
    unknown_if_bandwidth_hz: float = USUAL_IF_BANDWIDTH_HZ,
) -> float:
    """Return about how long a trace takes [s], with its averages.

    A narrower IF bandwidth makes each point longer by the time that its filter needs, which is
    about the inverse of the bandwidth.

    Args:
        sweep: What is measured.
        seconds_per_point: Duration of one point at the usual IF bandwidth [s].
        unknown_if_bandwidth_hz: Assumed where `sweep` leaves the bandwidth to the instrument [Hz].
    """
    bandwidth_hz = sweep.analyzer.if_bandwidth_hz or unknown_if_bandwidth_hz
    slower_s = max(0.0, 1.0 / bandwidth_hz - 1.0 / USUAL_IF_BANDWIDTH_HZ)
    return sweep.points * (seconds_per_point + slower_s) * max(1, sweep.analyzer.averages)


@dataclass(frozen=True, eq=False)
class Sweep:
    """One S21 sweep; making one checks every value.

    Times are whole microseconds since 1970 in UTC, the resolution of every stored form; the arrays
    are float64 of shape (points,).

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """

    frequency_hz: np.ndarray = forms.of(forms.FLOATS, "frequencies, ascending", "Hz")
    s21_real: np.ndarray = forms.of(forms.FLOATS, "real part of S21, linear", "1")
    s21_imag: np.ndarray = forms.of(forms.FLOATS, "imaginary part of S21, linear", "1")
    sweep_started_us: int = forms.of(forms.TIME, "when the sweep was triggered")
    sweep_ended_us: int = forms.of(forms.TIME, "when the end of the sweep was seen")
    quality: Tuple[str, ...] = forms.of(
        forms.list_of(forms.TEXT), "remarks on the quality; empty if there are none", rule=_REMARKS
    )
    analyzer: AnalyzerSettings  # type: ignore[misc]  # `of` is no default

    def __post_init__(self) -> None:
        forms.check(SWEEP_FIELDS, vars(self))
        forms.check(SETTINGS, vars(self.analyzer))
        for mistake in self._mistakes():
            forms.refuse(mistake, faults.VNA_FAILED)
        if self.sweep_ended_us < self.sweep_started_us:
            reason = Message(
                "sweep_ended {ended} lies before sweep_started {started}",
                ended=utc_time.iso_text(self.sweep_ended_us),
                started=utc_time.iso_text(self.sweep_started_us),
            )
            forms.refuse(reason, faults.CLOCK_WRONG)

    @property
    def duration_s(self) -> float:
        return (self.sweep_ended_us - self.sweep_started_us) * 1e-6

    def _mistakes(self) -> Iterator[Message]:
        points, hz = len(self.frequency_hz), self.frequency_hz
        if not MIN_POINTS <= points <= MAX_POINTS:
            yield Message(
                "there are {points} points; there must be {lower} to {upper}",
                points=points,
                lower=MIN_POINTS,
                upper=MAX_POINTS,
            )
        for name in ("frequency_hz", "s21_real", "s21_imag"):
            values = getattr(self, name)
            named = {"name": name, "count": values.size, "points": points}
            if values.dtype != np.float64 or values.shape != (points,):
                yield Message("{name} has {count} values for {points} frequencies", **named)
            if not np.isfinite(values).all():
                named["count"] = np.count_nonzero(~np.isfinite(values))
                yield Message("{name} contains {count} NaN or infinite values", **named)
        if hz[0] <= 0.0 or not (hz[1:] > hz[:-1]).all():
            yield Message("frequency_hz must be above zero and ascend from each point to the next")


SETTINGS, SWEEP_FIELDS = forms.fields_of(AnalyzerSettings), forms.fields_of(Sweep)


def storable_remark(remark: str) -> str:
    """Return a remark as a sweep accepts it: short, and with printable characters only."""
    text = "".join(one if one.isprintable() else "?" for one in remark)
    return text if len(text) <= MAX_REMARK_CHARACTERS else text[: MAX_REMARK_CHARACTERS - 3] + "..."
