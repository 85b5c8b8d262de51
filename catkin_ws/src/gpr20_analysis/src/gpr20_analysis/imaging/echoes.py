"""Echoes in an image: its local maxima."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y

NEAREST_M = 0.04
FAINTEST_DB = -15.0


@dataclass(frozen=True)
class Echo:
    """A local maximum of an image.

    Attributes:
        polarization_deg: Rotation of the antennas [deg]; NaN for a combination.
        x_m: Place along X [m].
        y_m: Place along Y [m].
        depth_m: Depth below the surface [m].
        level_db: Magnitude below the brightest voxel of all polarizations [dB].
        above_noise_db: Magnitude above the brightest voxel expected from noise of the same median
            magnitude [dB]; an echo below zero may be noise.
        width_x_m: -3 dB width along X [m]; NaN if the image ends before.
        width_y_m: The same along Y.
        width_depth_m: The same in depth.
    """

    polarization_deg: float
    x_m: float
    y_m: float
    depth_m: float
    level_db: float
    above_noise_db: float
    width_x_m: float
    width_y_m: float
    width_depth_m: float


def find_echoes(
    image: xr.Dataset, faintest_db: float = FAINTEST_DB, nearest_m: float = NEAREST_M
) -> List[Echo]:
    """Return the echoes of all polarizations, the brightest first.

    A maximum at the first or last depth is not an echo, since it may be higher beyond it.

    Args:
        image: Dataset with `image` (polarization, depth, y, x).
        faintest_db: Lowest level below the brightest voxel [dB].
        nearest_m: Of echoes closer to each other than this only the brighter one is returned [m].
    """
    magnitude = np.abs(image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X).values)
    brightest = float(magnitude.max())
    if not brightest > 0.0:
        return []
    axes = [image[name].values for name in (DEPTH, Y, X)]
    threshold = brightest * 10.0 ** (faintest_db / 20.0)
    echoes = []
    for turn, volume in zip(image[POLARIZATION].values, magnitude):
        levels = (brightest, noise_peak(volume))
        places = maxima(volume, axes, threshold, nearest_m)
        echoes += [_echo(float(turn), volume, axes, place, levels) for place in places]
    return sorted(echoes, key=lambda echo: -echo.level_db)


def noise_peak(volume: np.ndarray) -> float:
    """Return the expected magnitude of the brightest voxel of noise with the same median.

    The magnitude of complex Gaussian noise is distributed by Rayleigh's law: its median is
    s sqrt(2 ln 2), and the largest of N is near s sqrt(2 ln N), which one in N exceeds. It is
    smaller if the voxels are not independent.

    Args:
        volume: Magnitudes.
    """
    return float(np.median(volume)) * math.sqrt(math.log2(max(2, volume.size)))


def maxima(
    volume: np.ndarray, axes: Sequence[np.ndarray], threshold: float, nearest_m: float
) -> List[Tuple[int, ...]]:
    """Return the indices of local maxima of a volume (depth, y, x), except at the outer depths.

    Args:
        volume: Magnitudes.
        axes: Depths, positions along Y, positions along X [m].
        threshold: Lower maxima are left out.
        nearest_m: Of maxima closer than half of this only the highest is returned [m].
    """
    size = [
        2 * max(1, round(nearest_m / (2.0 * _step(axis)))) + 1 if len(axis) > 1 else 1
        for axis in axes
    ]
    highest = (volume == maximum_filter(volume, size=size)) & (volume >= threshold)
    highest[[0, -1]] = False
    return [tuple(int(index) for index in place) for place in np.argwhere(highest)]


def peak_place(
    volume: np.ndarray, axes: Sequence[np.ndarray], place: Tuple[int, ...]
) -> Tuple[float, ...]:
    """Return (depth, y, x) of a local maximum between the voxels [m]."""
    lines = lines_through(volume, place)
    return tuple(_peak(line, axis, index) for line, axis, index in zip(lines, axes, place))


def lines_through(volume: np.ndarray, place: Tuple[int, ...]) -> List[np.ndarray]:
    """Return the three lines of a volume through a voxel, one along each axis."""
    return [
        volume[tuple(slice(None) if other == axis else place[other] for other in range(3))]
        for axis in range(3)
    ]


def _echo(
    turn_deg: float,
    volume: np.ndarray,
    axes: List[np.ndarray],
    place: Tuple[int, ...],
    levels: Tuple[float, float],
) -> Echo:
    lines = lines_through(volume, place)
    depth_m, y_m, x_m = peak_place(volume, axes, place)
    width_depth_m, width_y_m, width_x_m = (
        _half_power_width(line, axis, index) for line, axis, index in zip(lines, axes, place)
    )
    level_db, above_noise_db = (
        20.0 * float(np.log10(volume[place] / one)) if one > 0.0 else math.inf for one in levels
    )
    return Echo(
        turn_deg,
        *(x_m, y_m, depth_m),
        *(level_db, above_noise_db),
        *(width_x_m, width_y_m, width_depth_m),
    )


def _step(axis: np.ndarray) -> float:
    return float(axis[-1] - axis[0]) / (len(axis) - 1)


def _peak(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return the maximum of a parabola through the logarithms of three voxels."""
    if index in (0, len(line) - 1) or np.any(line[index - 1 : index + 2] <= 0.0):
        return float(axis[index])
    before, top, after = np.log(line[index - 1 : index + 2])
    back_m, on_m = axis[index] - axis[index - 1], axis[index + 1] - axis[index]
    rise, fall = (top - before) / back_m, (after - top) / on_m
    if rise == fall:
        return float(axis[index])
    # The slope is linear between the middles of the two intervals.
    share = rise / (rise - fall)
    return float(axis[index] - back_m / 2.0 + share * (back_m + on_m) / 2.0)


def _half_power_width(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return the -3 dB width of a maximum; NaN if the line ends above that level."""
    level = float(line[index]) / math.sqrt(2.0)
    below = np.flatnonzero(line <= level)
    left, right = below[below < index], below[below > index]
    if not left.size or not right.size:
        return math.nan
    ends = [
        np.interp(level, line[[low, high]], axis[[low, high]])
        for low, high in ((left[-1], left[-1] + 1), (right[0], right[0] - 1))
    ]
    return float(ends[1] - ends[0])
