"""What a sweep consists of, and how finely it is simulated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

import numpy as np


@dataclass(frozen=True)
class SweepPlan:
    """What one sweep consists of.

    Attributes:
        start_hz: First frequency [Hz].
        stop_hz: Last frequency [Hz].
        points: Number of frequencies.
        seconds_per_point: Time that one frequency takes [s].
        averages: Number of sweeps that are averaged; 1: none.
        waits_for_average: Whether a trigger runs as many sweeps as are averaged, and only the
            end of the last one is reported.
        noise_gain: Noise relative to that of the settings of power-on.
    """

    start_hz: float
    stop_hz: float
    points: int
    seconds_per_point: float
    averages: int = 1
    waits_for_average: bool = False
    noise_gain: float = 1.0

    def frequency_hz(self) -> np.ndarray:
        """Return the frequencies [Hz]."""
        return np.linspace(self.start_hz, self.stop_hz, self.points)


@dataclass(frozen=True)
class SweepFaults:
    """What goes wrong with a triggered sweep.

    Attributes:
        stale: It is reported as complete at once, and its data are thrown away.
        slowest_point_s: No frequency takes less than this until the next trigger [s].
        shown_late_s: The display shows it so much later than its end [s]; until then, what it
            showed before.
        midway: Called once, from the sweeper's thread, when half of the sweep is done.
    """

    stale: bool = False
    slowest_point_s: float = 0.0
    shown_late_s: float = 0.0
    midway: Optional[Callable[[], object]] = None


NO_FAULTS = SweepFaults()


@dataclass(frozen=True)
class SweepPace:
    """How finely a sweep is simulated.

    Attributes:
        slice_s: Points of at most this time share one look at the antennas' position [s].
        shortest_period_s: A new sweep of a continuous series begins at most this often [s].
        rest_s: Replaces both in a series while nobody reads and nothing moves [s].
        attention_s: A reader or a move is waited for this long after the last one [s].
    """

    slice_s: float = 0.0015
    shortest_period_s: float = 0.010
    rest_s: float = 0.1
    attention_s: float = 1.0

    def faster(self, time_scale: float) -> SweepPace:
        """Return the pace that is as fine in real seconds by a clock so much faster."""
        return SweepPace(
            self.slice_s * time_scale,
            self.shortest_period_s * time_scale,
            self.rest_s * time_scale,
            self.attention_s * time_scale,
        )
