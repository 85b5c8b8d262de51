"""Echoes in an image: where it is locally brightest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis.mid.dataset import DEPTH, IMAGE, POLARIZATION, X, Y

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
        width_x_m: -3 dB width along X [m]; NaN if the image ends before.
        width_y_m: The same along Y.
        width_depth_m: The same in depth.
    """

    polarization_deg: float
    x_m: float
    y_m: float
    depth_m: float
    level_db: float
    width_x_m: float
    width_y_m: float
    width_depth_m: float


def find_echoes(
    image: xr.Dataset, faintest_db: float = FAINTEST_DB, nearest_m: float = NEAREST_M
) -> List[Echo]:
    """Return the echoes of all polarizations, the brightest first.

    A maximum in the first or last depth is none, since it may go on beyond it.

    Args:
        image: Dataset with `image` (polarization, depth, y, x).
        faintest_db: Lowest level below the brightest voxel [dB].
        nearest_m: Of echoes nearer to each other than this the brighter one is kept [m].
    """
    magnitude = np.abs(image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X).values)
    brightest = float(magnitude.max())
    if not brightest > 0.0:
        return []
    axes = [image[name].values for name in (DEPTH, Y, X)]
    threshold = brightest * 10.0 ** (faintest_db / 20.0)
    echoes = [
        _echo(float(turn), volume, axes, place, brightest)
        for turn, volume in zip(image[POLARIZATION].values, magnitude)
        for place in _maxima(volume, axes, threshold, nearest_m)
    ]
    return sorted(echoes, key=lambda echo: -echo.level_db)


def _maxima(
    volume: np.ndarray, axes: List[np.ndarray], threshold: float, nearest_m: float
) -> List[Tuple[int, ...]]:
    size = [
        2 * max(1, round(nearest_m / (2.0 * _step(axis)))) + 1 if len(axis) > 1 else 1
        for axis in axes
    ]
    highest = (volume == maximum_filter(volume, size=size)) & (volume >= threshold)
    highest[[0, -1]] = False
    return [tuple(int(index) for index in place) for place in np.argwhere(highest)]


def _echo(
    turn_deg: float,
    volume: np.ndarray,
    axes: List[np.ndarray],
    place: Tuple[int, ...],
    brightest: float,
) -> Echo:
    lines = [
        volume[tuple(slice(None) if other == axis else place[other] for other in range(3))]
        for axis in range(3)
    ]
    depth_m, y_m, x_m = (_peak(line, axis, index) for line, axis, index in zip(lines, axes, place))
    width_depth_m, width_y_m, width_x_m = (
        _half_power_width(line, axis, index) for line, axis, index in zip(lines, axes, place)
    )
    level_db = 20.0 * float(np.log10(volume[place] / brightest))
    return Echo(turn_deg, x_m, y_m, depth_m, level_db, width_x_m, width_y_m, width_depth_m)


def _step(axis: np.ndarray) -> float:
    return float(axis[-1] - axis[0]) / (len(axis) - 1)


def _peak(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return where a parabola through the logarithms of three voxels is highest."""
    if index in (0, len(line) - 1) or np.any(line[index - 1 : index + 2] <= 0.0):
        return float(axis[index])
    before, top, after = np.log(line[index - 1 : index + 2])
    bend = before - 2.0 * top + after
    shift = 0.0 if bend == 0.0 else 0.5 * (before - after) / bend
    return float(axis[index] + shift * _step(axis))


def _half_power_width(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    limit = line[index] / np.sqrt(2.0)
    left = _passes(line[index::-1], limit)
    right = _passes(line[index:], limit)
    return (left + right) * _step(axis) if len(axis) > 1 else float("nan")


def _passes(values: np.ndarray, limit: float) -> float:
    """Return after how many voxels falling values pass a limit; NaN if they never do."""
    below = np.flatnonzero(values < limit)
    if below.size == 0:
        return float("nan")
    after = int(below[0])
    return after - float((limit - values[after]) / (values[after - 1] - values[after]))
