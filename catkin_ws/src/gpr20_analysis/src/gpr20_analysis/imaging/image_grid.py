"""The positions of an image's columns, which need not be those of the survey."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import lazy
from gpr20_analysis.dataset import ATTRIBUTES, POLARIZATION, X, Y
from gpr20_analysis.errors import TooLargeError
from gpr20_common.message import Message

if TYPE_CHECKING:
    # The methods, which options name, import this module.
    from gpr20_analysis.imaging.image_options import ImageOptions

VOXEL_BYTES = 8
# Of the image of each polarization: as computed, stacked with the others, and its magnitude. Of
# the one that is being computed two more.
COPIES, COPIES_OF_ONE = 2.5, 2.0
# Of a step: positions are read from axes that count steps of 0.01 mm.
ROUNDING = 1e-3


def image_axes(survey: xr.Dataset, options: ImageOptions) -> Tuple[xr.DataArray, xr.DataArray]:
    """Return the positions of the image along X and along Y [m].

    Raises:
        TooLargeError: The image would not fit into the memory.
    """
    if options.grid_step_m is None:
        return survey[X], survey[Y]
    counts = [_count(survey[axis].values, options.grid_step_m) for axis in (X, Y)]
    _require_room(counts, len(options.depth_m), survey.sizes[POLARIZATION])
    x, y = (
        xr.DataArray(
            np.linspace(np.min(survey[axis].values), np.max(survey[axis].values), count),
            dims=axis,
            attrs=ATTRIBUTES[axis],
        )
        for axis, count in zip((X, Y), counts)
    )
    return x, y


def interpolated(
    spectra: np.ndarray, step_m: Tuple[float, float], x_m: np.ndarray, y_m: np.ndarray
) -> np.ndarray:
    """Return the image (depth, y, x) at any positions, from its spectra over wavenumber.

    It is the inverse transform, evaluated there: exact for what the survey's positions sample.

    Args:
        spectra: Discrete spectra (depth, wavenumber along Y, along X).
        step_m: Step of the positions that they are of, along Y and X [m].
        x_m: Positions along X, from the first position of the survey [m].
        y_m: The same along Y.
    """
    along_y, along_x = (
        (np.exp(2j * np.pi * np.outer(place_m, np.fft.fftfreq(count, step))) / count).astype(
            np.complex64
        )
        for place_m, count, step in zip((y_m, x_m), spectra.shape[1:], step_m)
    )
    image = np.empty((len(spectra), len(y_m), len(x_m)), dtype=np.complex64)
    for layer, spectrum in zip(image, spectra):
        np.matmul(along_y, spectrum @ along_x.T, out=layer)
    return image


def _count(position_m: np.ndarray, step_m: float) -> int:
    """Return how many positions cover the survey's from first to last, at most a step apart."""
    return 1 + math.ceil(float(np.ptp(position_m)) / step_m - ROUNDING)


def _require_room(counts: Sequence[int], depths: int, polarizations: int) -> None:
    copies = COPIES * polarizations + COPIES_OF_ONE
    needed = math.prod(counts) * depths * VOXEL_BYTES * copies
    if needed > lazy.available_bytes():
        raise TooLargeError(
            Message(
                "an image of {polarizations} x {depths} x {y} x {x} voxels needs "
                "{needed_mib:.0f} MiB of memory, but only {free_mib:.0f} MiB are free; use a "
                "larger --grid-step, fewer depths (--depth) or one polarization",
                x=counts[0],
                y=counts[1],
                depths=depths,
                polarizations=polarizations,
                needed_mib=needed / lazy.MIB,
                free_mib=lazy.available_bytes() / lazy.MIB,
            )
        )
