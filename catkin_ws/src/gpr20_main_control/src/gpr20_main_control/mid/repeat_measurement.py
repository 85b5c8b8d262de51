"""Comparison of a repeated measurement with the stored trace of the same point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class RepeatMeasurement:
    """The difference between a repeated measurement of a point and its stored trace.

    Attributes:
        index: The point's index in the plan.
        difference_db: Root mean square of the difference of S21, relative to the stored
            trace [dB]; minus infinity if they are equal.
        height_difference_m: New height minus the stored one [m]; NaN if either is missing.
    """

    index: int
    difference_db: float
    height_difference_m: float

    @property
    def message(self) -> Message:
        """The comparison in one sentence."""
        # As text: an infinite difference has no number in JSON.
        difference_db = f"{self.difference_db:.1f}"
        if not math.isfinite(self.height_difference_m):
            return Message(
                "point {index} was measured again and differs by {difference_db} dB from the "
                "stored trace",
                index=self.index,
                difference_db=difference_db,
            )
        return Message(
            "point {index} was measured again and differs by {difference_db} dB from the stored "
            "trace, the height by {height_mm:+.1f} mm",
            index=self.index,
            difference_db=difference_db,
            height_mm=1000.0 * self.height_difference_m,
        )


def compare(stored: Trace, sweep: Sweep, height_m: float) -> RepeatMeasurement:
    """Compare a new sweep of a point with the stored one.

    Args:
        stored: The trace on the disk.
        sweep: The new sweep, at the same frequencies.
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
