"""A known point: traces of one stop, measured again to compare the zeros of the axes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Collection, Dict, Iterable, List, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message, numeral
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.trace import Trace

# Another rotation must fit at least this many times better [power] to count as the true one.
ROTATION_FACTOR = 2.0


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
        below_db = numeral(-self.difference_db, ".1f")
        if not math.isfinite(self.height_difference_m):
            return Message(
                "point {index} was measured again; the difference is {below_db} dB below the "
                "stored trace",
                index=self.index,
                below_db=below_db,
            )
        return Message(
            "point {index} was measured again; the difference is {below_db} dB below the stored "
            "trace, that of the height {height_mm:+.1f} mm",
            index=self.index,
            below_db=below_db,
            height_mm=1000.0 * self.height_difference_m,
        )


def compare(stored: Trace, sweep: Sweep, height_m: float) -> RepeatMeasurement:
    """Compare a new sweep of a point with the stored one.

    Args:
        stored: The trace on the disk.
        sweep: The new sweep, at the same frequencies.
        height_m: The new height [m].
    """
    power = difference(stored, sweep)
    reference = _power(stored.s21_real, stored.s21_imag)
    if power == 0.0:
        difference_db = -math.inf
    else:
        difference_db = 10.0 * math.log10(power / reference) if reference else math.inf
    return RepeatMeasurement(stored.index, difference_db, height_m - stored.antennae_height_m)


def difference(stored: Sweep, sweep: Sweep) -> float:
    """Return the power of the difference of two sweeps, summed over their frequencies."""
    return _power(sweep.s21_real - stored.s21_real, sweep.s21_imag - stored.s21_imag)


def _power(real: np.ndarray, imag: np.ndarray) -> float:
    return float(np.sum(real**2) + np.sum(imag**2))


def known_traces(recent: Iterable[Trace], rotations: int) -> List[Trace]:
    """Return the latest stored traces of one stop at every rotation, in the order of their visit.

    Args:
        recent: Stored traces, the latest last.
        rotations: How many rotations the survey measures at each stop.

    Returns:
        One trace of each rotation, of one stop. Before the first stop is complete: the latest
        trace of each rotation so far.
    """
    ordered = sorted(recent, key=lambda trace: trace.index)
    stops: Dict[Tuple[float, float], Dict[float, Trace]] = {}
    latest: Dict[float, Trace] = {}
    for trace in ordered:
        stops.setdefault((trace.x_coord_mm, trace.y_coord_mm), {})[trace.z_coord_deg] = trace
        latest[trace.z_coord_deg] = trace
    complete = [stop for stop in stops.values() if len(stop) == rotations]
    chosen = complete[-1] if complete else latest
    return sorted(chosen.values(), key=lambda trace: trace.index)


@dataclass(frozen=True)
class KnownPoint:
    """What measuring a known point again says about the zeros.

    Attributes:
        repeats: The difference at each rotation.
        turned: Whether the new traces fit those of other rotations clearly better.
    """

    repeats: Tuple[RepeatMeasurement, ...]
    turned: bool

    def agrees(self, limit_db: float) -> bool:
        """Return whether every trace differs by less than a limit, and fits its own rotation."""
        return not self.turned and all(one.difference_db <= limit_db for one in self.repeats)

    @property
    def worst(self) -> RepeatMeasurement:
        """The repeat with the largest difference."""
        return max(self.repeats, key=lambda one: one.difference_db)

    @property
    def message(self) -> Message:
        """The comparison in one sentence."""
        return self.worst.message


def compare_known_point(stored: Sequence[Trace], measured: Sequence[Trace]) -> KnownPoint:
    """Compare the traces of a known point with new ones of the same points.

    Where the ground and its targets look the same at every rotation, a wrong rotation cannot
    show; where they do not, traces of a wrong rotation fit those of another one better.

    Args:
        stored: The traces on the disk.
        measured: New traces at the same points, in the same order.
    """
    repeats = tuple(compare(old, new, new.antennae_height_m) for old, new in zip(stored, measured))
    own = sum(difference(old, new) for old, new in zip(stored, measured))
    others = sum(
        min(difference(old, new) for old in _others(stored, place))
        for place, new in enumerate(measured)
        if len(stored) > 1
    )
    return KnownPoint(repeats, len(stored) > 1 and own > ROTATION_FACTOR * others)


def _others(traces: Sequence[Trace], place: int) -> Collection[Trace]:
    return [one for number, one in enumerate(traces) if number != place]
