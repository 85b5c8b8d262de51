"""One S21 sweep, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NoReturn, Tuple

import numpy as np

from gpr20_common.message import Fault, Message
from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace_form import FLOATS, TEXT, TIME, list_of, of

MIN_POINTS, MAX_POINTS = 2, 4001
MAX_REMARKS, MAX_REMARK_CHARACTERS = 32, 200
# Far beyond what any analyzer has.
MAX_IF_BANDWIDTH_HZ = 1.0e9
MAX_AVERAGES = 1_000_000
MAX_POWER_CHARACTERS = 32


@dataclass(frozen=True, eq=False)
class Sweep:
    """One S21 sweep; making one checks every value.

    Times are whole microseconds since 1970 in UTC, the resolution of every stored form; the arrays
    are float64 of shape (points,).

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """

    frequency_hz: np.ndarray = field(metadata=of(FLOATS, "frequencies, ascending", "Hz"))
    s21_real: np.ndarray = field(metadata=of(FLOATS, "real part of S21, linear", "1"))
    s21_imag: np.ndarray = field(metadata=of(FLOATS, "imaginary part of S21, linear", "1"))
    sweep_started_us: int = field(metadata=of(TIME, "when the sweep was triggered"))
    sweep_ended_us: int = field(metadata=of(TIME, "when the end of the sweep was seen"))
    quality: Tuple[str, ...] = field(
        metadata=of(list_of(TEXT), "remarks on the quality; empty if there are none")
    )
    analyzer: AnalyzerSettings

    def __post_init__(self) -> None:
        self._check_numbers()
        self._check_sweep_times()
        self._check_quality()
        self._check_analyzer()

    @property
    def duration_s(self) -> float:
        """How long the sweep took [s]."""
        return (self.sweep_ended_us - self.sweep_started_us) * 1e-6

    def _check_numbers(self) -> None:
        points = len(self.frequency_hz)
        if not MIN_POINTS <= points <= MAX_POINTS:
            refuse(
                Message(
                    "there are {points} points; there must be {lower} to {upper}",
                    points=points,
                    lower=MIN_POINTS,
                    upper=MAX_POINTS,
                ),
                fault=faults.WRONG_SWEEP,
            )
        for name in ("frequency_hz", "s21_real", "s21_imag"):
            self._check_array(name, points)
        if self.frequency_hz[0] <= 0.0 or not (np.diff(self.frequency_hz) > 0.0).all():
            refuse(
                Message("frequency_hz must be above zero and ascend from each point to the next"),
                fault=faults.WRONG_SWEEP,
            )

    def _check_array(self, name: str, points: int) -> None:
        values = getattr(self, name)
        if values.dtype != np.float64 or values.shape != (points,):
            refuse(
                Message(
                    "{name} has {count} values for {points} frequencies",
                    name=name,
                    count=values.size,
                    points=points,
                ),
                fault=faults.WRONG_SWEEP,
            )
        if not np.isfinite(values).all():
            refuse(
                Message(
                    "{name} contains {count} NaN or infinite values",
                    name=name,
                    count=np.count_nonzero(~np.isfinite(values)),
                ),
                fault=faults.WRONG_SWEEP,
            )

    def _check_sweep_times(self) -> None:
        check_time("sweep_started", self.sweep_started_us)
        check_time("sweep_ended", self.sweep_ended_us)
        if self.sweep_ended_us < self.sweep_started_us:
            refuse(
                Message(
                    "sweep_ended {ended} lies before sweep_started {started}",
                    ended=utc_time.iso_text(self.sweep_ended_us),
                    started=utc_time.iso_text(self.sweep_started_us),
                ),
                fault=faults.CLOCK_WRONG,
            )

    def _check_quality(self) -> None:
        if len(self.quality) > MAX_REMARKS:
            refuse(
                Message(
                    "quality has {count} remarks; at most {most} are allowed",
                    count=len(self.quality),
                    most=MAX_REMARKS,
                )
            )
        for remark in self.quality:
            if len(remark) > MAX_REMARK_CHARACTERS or not remark.isprintable():
                refuse(
                    Message(
                        "quality holds {remark}; a remark must be printable and have at most "
                        "{most} characters",
                        remark=shortened(remark),
                        most=MAX_REMARK_CHARACTERS,
                    )
                )

    def _check_analyzer(self) -> None:
        bandwidth_hz = self.analyzer.if_bandwidth_hz
        # Written so that NaN is refused, and a negative zero, which is the same in no stored form.
        if not 0.0 <= bandwidth_hz <= MAX_IF_BANDWIDTH_HZ or math.copysign(1.0, bandwidth_hz) < 0.0:
            _refuse_outside("if_bandwidth_hz", bandwidth_hz, MAX_IF_BANDWIDTH_HZ)
        if not 0 <= self.analyzer.averages <= MAX_AVERAGES:
            _refuse_outside("averages", self.analyzer.averages, MAX_AVERAGES)
        power = self.analyzer.output_power
        if len(power) > MAX_POWER_CHARACTERS or not power.isprintable():
            refuse(
                Message(
                    "output_power is {power}; it must be printable and have at most {most} "
                    "characters",
                    power=shortened(power),
                    most=MAX_POWER_CHARACTERS,
                ),
                fault=faults.WRONG_SWEEP,
            )


def storable_remark(remark: str) -> str:
    """Return a remark as a sweep accepts it: short, and with printable characters only."""
    text = "".join(one if one.isprintable() else "?" for one in remark)
    return text if len(text) <= MAX_REMARK_CHARACTERS else text[: MAX_REMARK_CHARACTERS - 3] + "..."


def check_time(name: str, time_us: int) -> None:
    """Refuse a moment [us since 1970] that cannot be right.

    Raises:
        TraceRefusedError: It cannot.
    """
    if not utc_time.is_plausible(time_us):
        refuse(
            Message(
                "{name} is {time}; set the computer's clock",
                name=name,
                time=utc_time.iso_text(time_us),
            ),
            fault=faults.CLOCK_WRONG,
        )


def refuse(reason: Message, fault: Fault = faults.TRACE_NOT_ALLOWED) -> NoReturn:
    """Raise the error of a trace that is not allowed.

    Args:
        reason: What is not allowed.
        fault: What it reports.

    Raises:
        TraceRefusedError: Always.
    """
    raise TraceRefusedError(Message("the trace is refused: {reason}", reason=reason), fault=fault)


def shortened(text: str) -> str:
    """Return a text in quotes, cut to what a message can hold."""
    return repr(text if len(text) <= 64 else text[:61] + "...")


def _refuse_outside(name: str, value: float, upper: float) -> NoReturn:
    refuse(
        Message(
            "{name} is {value}; it must lie between {lower} and {upper}",
            name=name,
            value=f"{value:.12g}",
            lower=0,
            upper=f"{upper:.12g}",
        ),
        fault=faults.WRONG_SWEEP,
    )
