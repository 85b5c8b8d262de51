"""What the views draw: levels on an even grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_analysis.dataset import A_SCAN, DELAY, MM_PER_M, POLARIZATION, X, Y
from gpr20_analysis.processing.delay import to_time
from gpr20_survey.radar import Window, decibels
from gpr20_viewer.live_image import NS_PER_S, LiveImage
from gpr20_viewer.positions import Line, Place
from gpr20_viewer.session import ViewSession

MOST_CELLS = 4000
"""Largest number of cells along an axis of a picture."""
PADDING = 3.0


@dataclass(frozen=True)
class Picture:
    """Levels on an even grid.

    Attributes:
        levels_db: Levels (down, across) [dB]; NaN: not measured.
        across: Place of the first and the last column [mm].
        down: Place of the first and the last row [mm or ns].
    """

    levels_db: np.ndarray
    across: Tuple[float, float]
    down: Tuple[float, float]

    @staticmethod
    def of(levels_db: np.ndarray, across: np.ndarray, down: np.ndarray) -> Picture:
        """Return the picture of levels at positions that may be uneven: the nearest is drawn."""
        rows, columns = _even(down), _even(across)
        return Picture(
            levels_db[rows][:, columns],
            (float(across[0]), float(across[-1])),
            (float(down[0]), float(down[-1])),
        )


def traces_picture(
    session: ViewSession, line: Line, turn: int, background: bool, until_s: float
) -> Picture:
    """Return the envelopes of the traces of a line over the delay.

    Levels are relative to the brightest one that is shown.

    Args:
        session: The survey.
        line: The line.
        turn: Index of the polarization.
        background: Whether the background is subtracted.
        until_s: Last delay [s].
    """
    other = Y if line.along == X else X
    data = session.data(background)
    row = int(np.argmin(np.abs(data[other].values - line.other_m)))
    in_time = to_time(data.isel({POLARIZATION: [turn], other: [row]}), Window.HANN, PADDING)
    in_time = in_time.sel({DELAY: in_time[DELAY].values <= until_s})
    delay_ns = in_time[DELAY].values * NS_PER_S
    values = np.abs(in_time[A_SCAN].transpose(POLARIZATION, other, DELAY, line.along).values[0, 0])
    levels_db = decibels(values, 1e-300)
    if np.isfinite(levels_db).any():
        levels_db -= np.nanmax(levels_db)
    return Picture.of(levels_db.astype(np.float32), line.position_m * MM_PER_M, delay_ns)


def section_picture(image: LiveImage, turn: int, along: str, at_m: float) -> Picture:
    """Return a vertical section of an image along "x" or "y"."""
    levels_db = image.levels_db[turn]
    if along == X:
        levels_db = levels_db[:, _nearest(image.y_m, at_m), :]
        across_m = image.x_m
    else:
        levels_db = levels_db[:, :, _nearest(image.x_m, at_m)]
        across_m = image.y_m
    return Picture.of(levels_db, across_m * MM_PER_M, image.depth_m * MM_PER_M)


def slice_picture(image: LiveImage, turn: int, depth_m: Optional[float]) -> Picture:
    """Return a horizontal slice of an image; without a depth, the maximum over all of them."""
    levels_db = image.levels_db[turn]
    across = levels_db.max(axis=0)
    if depth_m is not None:
        across = levels_db[_nearest(image.depth_m, depth_m)]
    return Picture.of(across, image.x_m * MM_PER_M, image.y_m * MM_PER_M)


def longest_delay_s(
    line: Line, deepest_m: float, permittivity: float, separation_m: float
) -> float:
    """Return the delay down to which traces are shown: the deepest layer, and a little more [s]."""
    middle = len(line.position_m) // 2
    at_m = float(line.position_m[middle])
    x_m, y_m = (at_m, line.other_m) if line.along == X else (line.other_m, at_m)
    delays_s = line.delays_s(Place(x_m, y_m, deepest_m), permittivity, separation_m)
    return 1.15 * float(delays_s[middle])


def _even(places: np.ndarray) -> np.ndarray:
    """Return the index of the nearest place for each cell of an even grid."""
    if len(places) < 3:
        return np.arange(len(places))
    smallest = float(np.min(np.diff(places)))
    count = 1 + round((places[-1] - places[0]) / smallest) if smallest > 0.0 else len(places)
    even = np.linspace(places[0], places[-1], min(count, MOST_CELLS))
    return np.abs(np.searchsorted((places[1:] + places[:-1]) / 2.0, even))


def _nearest(places: np.ndarray, at: float) -> int:
    return int(np.argmin(np.abs(places - at)))
