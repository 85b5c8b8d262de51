"""How long a sweep takes, whether its data are new, and the sweep that they make."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import Sweep, storable_remark
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
# A sweep that is this much later than that was begun again [s]; network and instrument need some.
RESTART_TOLERANCE_S = 0.05


@dataclass(frozen=True)
class SweepEnd:
    """How the end of a sweep was noticed.

    Attributes:
        asked_s: From the trigger to the query that showed the end [s].
        duration_s: From the trigger to the answer of that query [s].
        cleared: Whether the bit of the sweep before was seen cleared first.
        stale_bit_s: How long after the trigger the bit was still that of the sweep before [s].
        unfinished_s: How long after the trigger the sweep was seen not to have ended yet [s].
    """

    asked_s: float
    duration_s: float
    cleared: bool
    stale_bit_s: float = 0.0
    unfinished_s: float = 0.0


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
        self._surely_ended_s = DOUBT_FACTOR * longest_s + stale_s

    @property
    def expected_s(self) -> float:
        """When to ask for the end of a sweep, so that the first answer mostly shows it [s]."""
        ignored = int(IGNORED * len(self._recent_s))
        return sorted(self._recent_s)[-1 - ignored]

    @property
    def duration_s(self) -> float:
        """How long a sweep takes until its end is known [s]."""
        return self.expected_s + self._exchange_s

    @property
    def surely_ended_s(self) -> float:
        """When a sweep has certainly ended, whatever the bit says [s]."""
        return self._surely_ended_s

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


def restart_remarks(end: SweepEnd, surely_ended_s: float) -> Tuple[str, ...]:
    """Return a remark if a sweep had certainly not ended when it should long have.

    An instrument begins its sweep again when a setting is changed; one that is put back before the
    end shows in nothing else. A busy computer asks late, but cannot see an end that is missing.
    """
    if end.unfinished_s <= surely_ended_s + RESTART_TOLERANCE_S:
        return ()
    remark = Message(
        "the sweep had not ended after {unfinished_s:.3f} s, expected within {expected_s:.3f} s; a "
        "setting may have been changed and put back",
        unfinished_s=end.unfinished_s,
        expected_s=surely_ended_s,
    )
    return (storable_remark(str(remark)),)


def timed_sweep(
    settings: SweepSettings,
    numbers: np.ndarray,
    started_us: int,
    duration_s: float,
    remarks: Tuple[str, ...] = (),
) -> Sweep:
    """Return the sweep of these data.

    Args:
        settings: With which it was measured.
        numbers: Real and imaginary part of each point in turn.
        started_us: When it was triggered [us since 1970, UTC].
        duration_s: How long it took by a monotonic clock [s]: the time of day may be corrected
            meanwhile.
        remarks: On its quality.

    Raises:
        TraceRefusedError: A value is not allowed.
    """
    return Sweep(
        frequency_hz=settings.frequencies_hz(),
        s21_real=numbers[0::2].copy(),
        s21_imag=numbers[1::2].copy(),
        sweep_started_us=started_us,
        sweep_ended_us=started_us + round(duration_s * utc_time.US_PER_S),
        quality=remarks,
        analyzer=settings.analyzer,
    )
