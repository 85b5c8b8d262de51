"""Comparing a point that is measured again with what was stored of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class RepeatMeasurement:
    """How far a second measurement of a point is from the stored one.

    Attributes:
        index: The point's place in the plan.
        difference_db: Root mean square of the difference of S21, relative to the stored
            trace [dB]; minus infinity if they are equal.
        height_difference_m: New height minus the stored one [m]; NaN if either is missing.
    """

    index: int
    difference_db: float
    height_difference_m: float

    @property
    def text(self) -> str:
        """The comparison in one sentence."""
        height = ""
        if math.isfinite(self.height_difference_m):
            height = f", the height by {1000.0 * self.height_difference_m:+.1f} mm"
        return (
            f"measured again as a control, point {self.index} differs by "
            f"{self.difference_db:.1f} dB from the stored trace{height}"
        )


def compare(stored: Trace, sweep: Sweep, height_m: float) -> RepeatMeasurement:
    """Compare a new sweep of a point with the stored one.

    Args:
        stored: What is on the disk.
        sweep: The new one, at the same frequencies.
        height_m: The new height [m].
    """
    difference = _power(sweep.s21_real - stored.s21_real, sweep.s21_imag - stored.s21_imag)
    reference = _power(stored.s21_real, stored.s21_imag)
    if difference == 0.0:
        difference_db = -math.inf
    else:
        difference_db = 10.0 * math.log10(difference / reference) if reference else math.inf
    return RepeatMeasurement(stored.index, difference_db, height_m - stored.antennae_height_m)


def _power(real: np.ndarray, imag: np.ndarray) -> float:
    return float(np.sum(real**2) + np.sum(imag**2))
