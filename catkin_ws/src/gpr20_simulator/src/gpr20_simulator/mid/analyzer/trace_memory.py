"""What the display of the simulated analyzer holds, computed when somebody looks."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Deque, List, Optional, Tuple

import numpy as np

from gpr20_simulator.mid.world.medium import AntennaPosition, SweptMedium

# The newest sweep has only begun, so the one before it is needed for the other points.
MOST_WAITING_SWEEPS = 2


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


class TraceMemory:
    """The data of the display: each point as it was swept last.

    A late display shows a sweep only some time after its end, and until then what it showed
    before. Not safe for several threads at a time.

    Args:
        medium: What is measured.
        frequency_hz: The frequencies [Hz].
    """

    def __init__(self, medium: SweptMedium, frequency_hz: np.ndarray) -> None:
        self._medium = medium
        self._frequency_hz = frequency_hz
        self._data = np.zeros(len(frequency_hz), dtype=np.complex64)
        # Parts by sweep, to be measured when somebody looks.
        self._waiting: Deque[List[SweepPart]] = deque(maxlen=MOST_WAITING_SWEEPS)
        # What is shown instead of the data; what will be shown, and from when on [s].
        self._frozen: Optional[np.ndarray] = None
        self._coming: Deque[Tuple[float, np.ndarray]] = deque()

    def set_frequencies(self, frequency_hz: np.ndarray) -> None:
        """Hold other frequencies [Hz]; data of as many points stay, as on a display."""
        self.compute()
        self.set_late(False)
        self._frequency_hz = frequency_hz
        if len(frequency_hz) != len(self._data):
            self._data = np.zeros(len(frequency_hz), dtype=np.complex64)

    def store(self, part: SweepPart) -> None:
        """Take a part into the data, to be measured when somebody looks at it."""
        if not self._waiting or self._waiting[-1][-1].sweep_number != part.sweep_number:
            self._waiting.append([part])
            return
        parts = self._waiting[-1]
        if part.continues(parts[-1]):
            parts[-1] = replace(parts[-1], end=part.end)
        else:
            parts.append(part)

    def compute(self) -> None:
        """Measure what is waiting."""
        while self._waiting:
            for part in self._waiting.popleft():
                self._data[part.first : part.end] = self._medium.s21(
                    self._frequency_hz[part.first : part.end],
                    part.position,
                    part.sweep_number,
                    part.noise_gain,
                )

    def set_late(self, late: bool) -> None:
        """From now on show what is shown now until a sweep comes that has ended, or the data."""
        if not late:
            self._frozen = None
            self._coming.clear()
        elif self._frozen is None:
            self._frozen = self._computed()

    def end_sweep(self, shown_s: float) -> None:
        """Let a late display show from a moment on [s] what was measured until now."""
        if self._frozen is not None:
            self._coming.append((shown_s, self._computed()))

    def shown(self, now_s: float) -> np.ndarray:
        """Return a copy of the data (complex64) that are shown now."""
        while self._coming and self._coming[0][0] <= now_s:
            _shown_s, self._frozen = self._coming.popleft()
        return self._computed() if self._frozen is None else self._frozen.copy()

    def _computed(self) -> np.ndarray:
        self.compute()
        return self._data.copy()
