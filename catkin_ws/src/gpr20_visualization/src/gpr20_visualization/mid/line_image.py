"""A line of a survey as a grey picture: its B-scan."""

from __future__ import annotations

from typing import Dict, Optional, Sequence, Tuple

import numpy as np

from gpr20_survey.radar.frequency_to_delay import FrequencyToDelay, decibels, unambiguous_s
from gpr20_survey.trace.trace import Trace

DELAY_STEP_S = 0.05e-9
MAX_ROWS = 200
DARKEST_DB = -60.0
WHITE = 255


def transform_of(frequency_hz: np.ndarray) -> FrequencyToDelay:
    """Return the transform of sweeps with these frequencies to the rows of a picture."""
    rows = int(unambiguous_s(frequency_hz) / DELAY_STEP_S)
    return FrequencyToDelay(frequency_hz, DELAY_STEP_S, min(MAX_ROWS, max(2, rows)))


def grey(echoes: np.ndarray) -> np.ndarray:
    """Return the picture of a line at one antenna rotation (delays x stops, uint8).

    What all stops have in common (direct wave, level surface) is removed. White is the strongest
    echo of the line before that; black is 60 dB below it, or weaker.

    Args:
        echoes: Complex echoes (stops x delays); rows of NaN were not measured.
    """
    measured = ~np.isnan(echoes[:, 0])
    levels_db = np.full(echoes.shape, DARKEST_DB)
    present = echoes[measured]
    strongest = np.abs(present).max() if len(present) else 0.0
    if strongest > 0.0:
        left = present - present.mean(axis=0) if len(present) > 1 else present
        ratio = np.abs(left) / strongest
        levels_db[measured] = decibels(ratio, 10.0 ** (DARKEST_DB / 20.0))
    shades = WHITE * (1.0 - np.minimum(levels_db, 0.0) / DARKEST_DB)
    picture: np.ndarray = np.rint(shades).astype(np.uint8).T
    return picture


def side_by_side(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Return pictures beside each other, with a white line between them."""
    between = np.full((pictures[0].shape[0], 1), WHITE, np.uint8)
    return np.hstack([part for one in pictures for part in (between, one)][1:])


class LineImage:
    """Collects the traces of one line along X, and draws them."""

    def __init__(self, transform: Optional[FrequencyToDelay] = None) -> None:
        """Begin a line; a transform of the line before saves its computation."""
        self.transform = transform
        self._echoes: Dict[Tuple[float, float], np.ndarray] = {}

    def __len__(self) -> int:
        """Return how many samples it has; one that was measured again counts once."""
        return len(self._echoes)

    def add(self, trace: Trace) -> None:
        """Add a trace; one at the same place and rotation replaces the former."""
        if self.transform is None or not self.transform.fits(trace.frequency_hz):
            self.transform = transform_of(trace.frequency_hz)
            self._echoes = {}
        s21 = trace.s21_real + 1j * trace.s21_imag
        self._echoes[trace.z_coord_deg, trace.x_coord_mm] = self.transform.transform(s21)

    def picture(self) -> np.ndarray:
        """Return the picture (delays x stops): X ascending, one part for each rotation, ascending.

        The line must have a trace.
        """
        rotations = sorted({rotation for rotation, _x in self._echoes})
        xs = sorted({x for _rotation, x in self._echoes})
        missing = np.full_like(next(iter(self._echoes.values())), np.nan)
        return side_by_side(
            [
                grey(np.array([self._echoes.get((rotation, x), missing) for x in xs]))
                for rotation in rotations
            ]
        )
