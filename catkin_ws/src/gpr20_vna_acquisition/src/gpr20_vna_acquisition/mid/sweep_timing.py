"""How long a sweep takes, whether its data are new, and the sweep that they make."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np

from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings

# Successive points that have the bits of the sweep before. Noise changes every point.
OLD_POINTS = 3
# Sweeps with which a duration is learned, while they take less than this [s] together.
MOST_LEARNED, LEARNING_S = 3, 1.5
# How many sweeps a late one is remembered for, and the share of them whose lateness is ignored: a
# computer that was busy once must not delay all the sweeps that follow.
REMEMBERED = 32
IGNORED = 1 / 8
# A bit that was not seen cleared is believed this much later than the sweep must have ended.
DOUBT_FACTOR = 1.1


@dataclass(frozen=True)
class SweepEnd:
    """How the end of a sweep was noticed.

    Attributes:
        asked_s: From the trigger to the query that showed the end [s].
        duration_s: From the trigger to the answer of that query [s].
        cleared: Whether the bit of the sweep before was seen cleared first.
        stale_bit_s: How long after the trigger the bit was still that of the sweep before [s].
    """

    asked_s: float
    duration_s: float
    cleared: bool
    stale_bit_s: float = 0.0


class SweepTiming:
    """What is known about the duration of a sweep with the present settings."""

    def __init__(self, ends: Sequence[SweepEnd]) -> None:
        """Learn from some sweeps, one at least."""
        # The shortest is the one that the computer disturbed least.
        self._usual_s = min(end.asked_s for end in ends)
        self._recent_s = deque([self._usual_s], maxlen=REMEMBERED)
        self._exchange_s = min(end.duration_s for end in ends) - self._usual_s
        longest_s = max(end.duration_s for end in ends)
        stale_s = max(end.stale_bit_s for end in ends)
        # When a sweep has certainly ended, whatever the bit says [s].
        self.surely_ended_s = DOUBT_FACTOR * longest_s + stale_s

    @property
    def expected_s(self) -> float:
        """When to ask for the end of a sweep, so that the first answer mostly shows it [s]."""
        ignored = int(IGNORED * len(self._recent_s))
        return sorted(self._recent_s)[-1 - ignored]

    @property
    def duration_s(self) -> float:
        """How long a sweep takes until its end is known [s]."""
        return self.expected_s + self._exchange_s

    def note(self, end: SweepEnd, late: bool) -> None:
        """Note another sweep; `late`: it had not ended when that was expected."""
        self._recent_s.append(end.asked_s if late else self._usual_s)


def enough_learned(ends: Sequence[SweepEnd]) -> bool:
    """Return whether so many sweeps show how long one takes."""
    return len(ends) >= MOST_LEARNED or sum(end.duration_s for end in ends) >= LEARNING_S


def has_old_points(
    numbers: np.ndarray, before: Optional[np.ndarray], to_the_last: bool = False
) -> bool:
    """Return whether a part of the data is that of the sweep before, to the last bit.

    An instrument that is read before a sweep has ended answers with new points up to some
    frequency, and old points from there on.

    Args:
        numbers: Real and imaginary part of each point in turn.
        before: Those of the sweep before; None if they are not known.
        to_the_last: Whether a single old point at the end counts. Coarsely rounded numbers can be
            equal by chance, which then costs time.
    """
    if before is None or len(before) != len(numbers):
        return False
    same = (numbers.reshape(-1, 2) == before.reshape(-1, 2)).all(axis=1)
    if to_the_last and same[-1]:
        return True
    run = min(OLD_POINTS, len(same))
    return bool(np.convolve(same, np.ones(run), "valid").max() >= run)


def timed_sweep(
    settings: SweepSettings, numbers: np.ndarray, started_us: int, duration_s: float
) -> Sweep:
    """Return the sweep of these data: real and imaginary part of each point in turn.

    Args:
        settings: With which it was measured.
        numbers: The data.
        started_us: When it was triggered [us since 1970, UTC].
        duration_s: How long it took by a monotonic clock [s]: the time of day may be corrected
            meanwhile.
    """
    return Sweep(
        frequency_hz=settings.frequencies_hz(),
        s21_real=numbers[0::2].copy(),
        s21_imag=numbers[1::2].copy(),
        sweep_started_us=started_us,
        sweep_ended_us=started_us + round(duration_s * utc_time.US_PER_S),
        quality=(),
        analyzer=settings.analyzer,
    )
