"""What the display of the simulated analyzer holds, computed when somebody looks."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Deque, List, Optional, Tuple

import numpy as np

from gpr20_simulator.mid.world.medium import AntennaPosition, SweptMedium

# Older sweeps of an average that nobody has looked at count as if the next one were they.
MOST_WAITING_SWEEPS = 16


@dataclass(frozen=True)
class SweepPart:
    """Neighbouring points of a sweep that are measured at one position.

    Attributes:
        sweep_number: Number of the sweep.
        first: Index of the first point.
        end: Index after the last point.
        position: Where the antennas were.
        noise_gain: Noise relative to that of the settings of power-on.
    """

    sweep_number: int
    first: int
    end: int
    position: AntennaPosition
    noise_gain: float

    def continues(self, other: SweepPart) -> bool:
        """Return whether it can be measured in one with the part before it."""
        return replace(other, first=self.first, end=self.end) == self and other.end == self.first


@dataclass
class _WaitingSweep:
    sweep_number: int
    share: float
    parts: List[SweepPart] = field(default_factory=list)


class TraceMemory:
    """The data of the display: each point as it was swept last, or its average.

    Not safe for several threads at a time.

    Args:
        medium: What is measured.
        frequency_hz: The frequencies [Hz].
    """

    def __init__(self, medium: SweptMedium, frequency_hz: np.ndarray) -> None:
        self._medium = medium
        self._frequency_hz = frequency_hz
        self._data = np.zeros(len(frequency_hz), dtype=np.complex64)
        self._waiting: Deque[_WaitingSweep] = deque()

    def set_frequencies(self, frequency_hz: np.ndarray) -> None:
        """Hold other frequencies [Hz]; data of as many points stay, as on a display."""
        self.compute()
        self._frequency_hz = frequency_hz
        if len(frequency_hz) != len(self._data):
            self._data = np.zeros(len(frequency_hz), dtype=np.complex64)

    def measured(self, part: SweepPart) -> np.ndarray:
        """Return what is measured of a part."""
        frequency_hz = self._frequency_hz[part.first : part.end]
        return self._medium.s21(frequency_hz, part.position, part.sweep_number, part.noise_gain)

    def store(self, part: SweepPart, values: Optional[np.ndarray], share: float) -> None:
        """Take a part into the data, with a share of 1 instead of what was there.

        Args:
            part: Which points.
            values: What was measured; None: to be measured only when somebody looks at it.
            share: Share of the average that it takes.
        """
        if values is None:
            self._store_later(part, share)
        else:
            self.compute()
            self._mix(part, values, share)

    def _mix(self, part: SweepPart, values: np.ndarray, share: float) -> None:
        here = self._data[part.first : part.end]
        # Without averaging the value itself: the difference would lose bits of it.
        here[:] = values if share == 1.0 else here + (values - here) * share

    def _store_later(self, part: SweepPart, share: float) -> None:
        if not self._waiting or self._waiting[-1].sweep_number != part.sweep_number:
            self._waiting.append(_WaitingSweep(part.sweep_number, share))
            self._forget_old()
        parts = self._waiting[-1].parts
        if parts and part.continues(parts[-1]):
            parts[-1] = replace(parts[-1], end=part.end)
        else:
            parts.append(part)

    def compute(self) -> None:
        """Measure what is waiting."""
        while self._waiting:
            sweep = self._waiting.popleft()
            for part in sweep.parts:
                self._mix(part, self.measured(part), sweep.share)

    def data(self) -> np.ndarray:
        """Return a copy of the data (complex64) as they are now."""
        self.compute()
        return self._data.copy()

    def _forget_old(self) -> None:
        # The newest sweep has only begun, so the one before it is needed for the other points.
        while len(self._waiting) > 2:
            is_averaged = self._waiting[1].share < 1.0
            if is_averaged and len(self._waiting) <= MOST_WAITING_SWEEPS:
                return
            forgotten = self._waiting.popleft()
            heir = self._waiting[0]
            heir.share = 1.0 - (1.0 - forgotten.share) * (1.0 - heir.share)


class LateDisplay:
    """What is shown of a memory whose sweeps reach the display only some time after their end.

    Not safe for several threads at a time.

    Args:
        memory: What was measured.
    """

    def __init__(self, memory: TraceMemory) -> None:
        self._memory = memory
        # What is shown instead of the memory; what will be shown, and from when on [s].
        self._frozen: Optional[np.ndarray] = None
        self._coming: Deque[Tuple[float, np.ndarray]] = deque()

    def set_late(self, late: bool) -> None:
        """From now on show what is shown now until a sweep comes that has ended, or the memory."""
        if not late:
            self.clear()
        elif self._frozen is None:
            self._frozen = self._memory.data()

    def measured(self, shown_s: float) -> None:
        """Let what the memory holds now be shown from a moment on [s]."""
        if self._frozen is not None:
            self._coming.append((shown_s, self._memory.data()))

    def shown(self, now_s: float) -> np.ndarray:
        """Return a copy of the data that are shown now."""
        while self._coming and self._coming[0][0] <= now_s:
            _shown_s, self._frozen = self._coming.popleft()
        return self._memory.data() if self._frozen is None else self._frozen.copy()

    def clear(self) -> None:
        """Show the memory as it is."""
        self._frozen = None
        self._coming.clear()
