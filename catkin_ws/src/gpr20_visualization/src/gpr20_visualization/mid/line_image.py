"""A line of a survey as a grey picture: its B-scan."""

from __future__ import annotations

from typing import Dict, Optional, Sequence, Tuple

import numpy as np

from gpr20_survey.trace.trace import Trace

DELAY_STEP_S = 0.05e-9
MAX_ROWS = 200
DARKEST_DB = -60.0
# A line is at least so many pixels wide, so that displays show it in full height.
SMALLEST_WIDTH = 200
WHITE = 255


class FrequencyToDelay:
    """Turns sweeps of one set of frequencies into echoes over delay.

    Convention: S21 ~ exp(-2j pi f tau). The band is weighted with a Hann window, so that a single
    echo of level 1 has a peak of 1.
    """

    def __init__(self, frequency_hz: np.ndarray) -> None:
        """Make it for ascending frequencies [Hz], at least two."""
        self._frequency_hz = frequency_hz
        spacing_hz = (frequency_hz[-1] - frequency_hz[0]) / (len(frequency_hz) - 1)
        rows = min(MAX_ROWS, max(2, int(1.0 / spacing_hz / DELAY_STEP_S)))
        window = np.hanning(len(frequency_hz) + 2)[1:-1]
        # The centre frequency is taken out, which changes no magnitude.
        relative_hz = frequency_hz - frequency_hz.mean()
        turns = np.outer(relative_hz, np.arange(rows) * DELAY_STEP_S)
        kernel = np.exp(2j * np.pi * turns) * (window / window.sum())[:, np.newaxis]
        self._kernel = kernel.astype(np.complex64)

    def fits(self, frequency_hz: np.ndarray) -> bool:
        """Return whether a sweep has these frequencies."""
        return np.array_equal(frequency_hz, self._frequency_hz)

    def echoes(self, trace: Trace) -> np.ndarray:
        """Return the echoes of a trace, one for each DELAY_STEP_S from 0."""
        s21 = (trace.s21_real + 1j * trace.s21_imag).astype(np.complex64)
        found: np.ndarray = s21 @ self._kernel
        return found


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
        levels_db[measured] = 20.0 * np.log10(np.maximum(ratio, 10.0 ** (DARKEST_DB / 20.0)))
    shades = WHITE * (1.0 - np.minimum(levels_db, 0.0) / DARKEST_DB)
    picture: np.ndarray = np.rint(shades).astype(np.uint8).T
    return picture


def side_by_side(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Return pictures beside each other, with a white line between them.

    Each stop is made as many pixels wide as the whole needs to be SMALLEST_WIDTH wide.
    """
    columns = sum(one.shape[1] for one in pictures)
    factor = max(1, -(-SMALLEST_WIDTH // columns))
    parts = [np.repeat(one, factor, axis=1) for one in pictures]
    between = np.full((parts[0].shape[0], 1), WHITE, np.uint8)
    joined = [parts[0]]
    for part in parts[1:]:
        joined += [between, part]
    return np.hstack(joined)


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
            self.transform = FrequencyToDelay(trace.frequency_hz)
            self._echoes = {}
        self._echoes[trace.z_coord_deg, trace.x_coord_mm] = self.transform.echoes(trace)

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
