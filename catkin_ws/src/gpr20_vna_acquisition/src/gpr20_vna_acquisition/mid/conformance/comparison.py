"""Whether sweeps show what they must: comparisons of their data."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep import Sweep
from gpr20_vna_acquisition.mid.conformance.bench import NotAsPromisedError, Outcome, Status
from gpr20_vna_acquisition.mid.refusals import old_data

# Sweeps of different things differ by so many times more than those of the same one.
CLEAR_DIFFERENCE = 5.0


def judged_first(before: Sweep, after: Sequence[Sweep], alike: Message) -> Outcome:
    """Judge whether the first of some sweeps shows what was changed before it."""
    first, second, third = after
    noise = _difference(second, third)
    if _difference(before, third) < CLEAR_DIFFERENCE * noise:
        return Status.NOT_TESTED, alike
    if _difference(first, before) < _difference(first, third):
        raise old_data()
    return Status.PASSED, Message("the first sweep after a change shows it")


def _difference(one: Sweep, other: Sweep) -> float:
    if len(one.s21_real) != len(other.s21_real):
        return float("inf")
    return float(np.median(np.abs(_complex(one) - _complex(other))))


def _complex(sweep: Sweep) -> np.ndarray:
    return sweep.s21_real + 1j * sweep.s21_imag


def numbers_of(sweep: Sweep) -> np.ndarray:
    """Return real and imaginary part of each point in turn."""
    return np.column_stack((sweep.s21_real, sweep.s21_imag)).ravel()


def refuse_doubled(sweep: Sweep) -> None:
    """Refuse data that hold everything twice."""
    values, half = _complex(sweep), len(sweep.s21_real) // 2
    in_pairs = (values[0 : 2 * half : 2] == values[1 : 2 * half : 2]).all()
    if in_pairs or (values[:half] == values[half : 2 * half]).all():
        raise NotAsPromisedError(Message("the data of a sweep hold every value twice"))
