"""One scale of levels for everything that is shown of a survey, anchored at its noise floor.

Levels are in dB above the noise floor. The darkest shade is just below the level that noise alone
does not exceed, the brightest one at the strongest echoes of the whole survey: both are the same
at each depth and on each line. Noise alone reaches less than a tenth of the scale.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

import numpy as np

from gpr20_operator.ground.noise import noise_threshold_db
from gpr20_survey.radar.frequency_to_delay import SMALLEST_LEVEL, decibels

# The darkest shade is so much below the highest level of noise, so that what comes close to it is
# not lost, and the brightest one at least so much above it [dB].
BELOW_THRESHOLD_DB = 2.0
MIN_SPAN_DB = 26.0
# The brightest level is a multiple of this, so that it changes rarely [dB].
TOP_STEP_DB, TICK_STEP_DB = 5.0, 10.0
# Smaller changes of the noise floor are not followed [dB].
HYSTERESIS_DB = 0.5


@dataclass(frozen=True)
class LevelScale:
    """How levels become shades.

    Args:
        noise: Root mean square of the noise, as an amplitude.
        threshold_db: Level that noise alone does not exceed [dB above noise].
        top_db: Level of the brightest shade [dB above noise].
        in_db: Shades follow the level in dB instead of the amplitude.
    """

    noise: float
    threshold_db: float
    top_db: float
    in_db: bool = True

    @property
    def dark_db(self) -> float:
        """The level of the darkest shade of a scale in dB [dB above noise]."""
        return self.threshold_db - BELOW_THRESHOLD_DB

    def levels_db(self, amplitudes: np.ndarray) -> np.ndarray:
        """Return levels of amplitudes [dB above noise]; NaN stays NaN."""
        return decibels(amplitudes) - float(decibels(self.noise))

    def shades(self, levels_db: np.ndarray, gain_db: Union[float, np.ndarray] = 0.0) -> np.ndarray:
        """Return shades from 0, noise, to 1 (float32); NaN stays NaN.

        Args:
            levels_db: Levels without gain [dB above noise].
            gain_db: By how much each is shown stronger [dB]. Noise would be amplified too, so
                that the gain is limited where noise would become visible.
        """
        gain_db = np.minimum(gain_db, self.top_db - self.threshold_db - MIN_SPAN_DB)
        if self.in_db:
            parts = (levels_db - self.dark_db) / (self.top_db - gain_db - self.dark_db)
        else:
            parts = 10.0 ** ((levels_db + gain_db - self.top_db) / 20.0)
        return np.clip(parts, 0.0, 1.0).astype(np.float32)

    def shade_of(self, level_db: float) -> float:
        """Return the shade of a level without gain [dB above noise]."""
        return float(self.shades(np.array(level_db)))

    def ticks_db(self) -> np.ndarray:
        """Return round levels between the ends of the scale [dB above noise]."""
        first = math.ceil(self.dark_db / TICK_STEP_DB) * TICK_STEP_DB
        return np.arange(first, self.top_db + 1.0, TICK_STEP_DB)


class SteadyScale:
    """The scale of a survey while its traces arrive: it changes rarely and its top only rises.

    Args:
        samples: How many values of noise the planned survey has.
    """

    def __init__(self, samples: int) -> None:
        self._threshold_db = noise_threshold_db(samples)
        self._noise = 0.0
        self._strongest = 0.0

    def update(self, noise: float, strongest: float) -> None:
        """Take what is known now.

        Args:
            noise: Noise floor, as an amplitude.
            strongest: Amplitude of the strong echoes of the survey.
        """
        noise = max(noise, SMALLEST_LEVEL)
        if self._noise == 0.0 or abs(decibels(noise / self._noise)) > HYSTERESIS_DB:
            self._noise = noise
        self._strongest = max(self._strongest, strongest)

    def scale(self, in_db: bool) -> LevelScale:
        """Return the scale now."""
        noise = max(self._noise, SMALLEST_LEVEL)
        strongest_db = float(decibels(max(self._strongest, SMALLEST_LEVEL) / noise))
        top_db = max(strongest_db, self._threshold_db + MIN_SPAN_DB)
        top_db = math.ceil(top_db / TOP_STEP_DB) * TOP_STEP_DB
        return LevelScale(noise, self._threshold_db, top_db, in_db)
