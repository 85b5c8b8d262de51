"""What a sweep covers, and the frequencies that follow from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SweepSettings:
    """Start and stop frequency [Hz], both measured, and the number of points."""

    start_frequency_hz: float
    stop_frequency_hz: float
    points: int

    def frequencies_hz(self) -> np.ndarray:
        """Return the measured frequencies [Hz, float64], ascending."""
        return np.linspace(self.start_frequency_hz, self.stop_frequency_hz, self.points)
