"""One S21 sweep, checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace_form import FLOATS, TEXT, TIME, check, fields_of, list_of, of
from gpr20_survey.trace.trace_rule import PLAUSIBLE, Rule, printable, refuse

MIN_POINTS, MAX_POINTS = 2, 4001
MAX_REMARKS, MAX_REMARK_CHARACTERS = 32, 200
_REMARK = printable(MAX_REMARK_CHARACTERS)
_REMARKS = Rule(
    lambda remarks: len(remarks) <= MAX_REMARKS and all(map(_REMARK.holds, remarks)),
    Message(
        "at most {most} remarks, each printable and of at most {characters} characters",
        most=MAX_REMARKS,
        characters=MAX_REMARK_CHARACTERS,
    ),
)


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
    sweep_started_us: int = field(metadata=of(TIME, "when the sweep was triggered", rule=PLAUSIBLE))
    sweep_ended_us: int = field(
        metadata=of(TIME, "when the end of the sweep was seen", rule=PLAUSIBLE)
    )
    quality: Tuple[str, ...] = field(
        metadata=of(list_of(TEXT), "remarks on the quality; empty if there are none", rule=_REMARKS)
    )
    analyzer: AnalyzerSettings

    def __post_init__(self) -> None:
        check(_FIELDS, vars(self))
        check(SETTINGS, vars(self.analyzer))
        self._check_numbers()
        self._check_sweep_times()

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
        ascends = (self.frequency_hz[1:] > self.frequency_hz[:-1]).all()
        if self.frequency_hz[0] <= 0.0 or not ascends:
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
        if self.sweep_ended_us < self.sweep_started_us:
            refuse(
                Message(
                    "sweep_ended {ended} lies before sweep_started {started}",
                    ended=utc_time.iso_text(self.sweep_ended_us),
                    started=utc_time.iso_text(self.sweep_started_us),
                ),
                fault=faults.CLOCK_WRONG,
            )


SETTINGS = tuple(fields_of(AnalyzerSettings).values())
_FIELDS = tuple(fields_of(Sweep).values())


def storable_remark(remark: str) -> str:
    """Return a remark as a sweep accepts it: short, and with printable characters only."""
    text = "".join(one if one.isprintable() else "?" for one in remark)
    return text if len(text) <= MAX_REMARK_CHARACTERS else text[: MAX_REMARK_CHARACTERS - 3] + "..."
