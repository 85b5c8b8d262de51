"""One S21 sweep, checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.trace import trace_form as forms
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

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
