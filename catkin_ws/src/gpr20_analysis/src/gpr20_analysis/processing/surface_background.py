"""The background of traces whose antennas are not all at one height above the surface.

Coupling stays at its delay, while the surface echo moves with the height, so no mean over the
traces as measured contains it. At each frequency the background is the sum of a constant, the
echo of a level surface at each recorded height, and a change of that echo with the height (which
takes up its strength, its delay and errors of the height's scale to the first order). The three
factors are fitted to all traces by least squares.

The noise of the height sensor is no reason to remove more than the mean. So the echo is fitted
only if that removes clearly more than components without a meaning would by chance, of what the
mean leaves.
"""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import lazy
from gpr20_analysis.dataset import FREQUENCY, HEIGHT, POLARIZATION, SAMPLE_DIMS, X, Y
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_survey.radar.depth import two_way_delay_s

COMPONENT = "component"
# A background of as many components as traces would be the traces themselves.
TRACES_PER_COMPONENT = 10
MOST_COMPONENTS = 3
# Times the share that a component without a meaning removes, which is 1 / traces.
LEAST_GAIN = 5.0
# Standard deviation of heights that differ by rounding only.
EQUAL_M = 1e-6
# Components whose share is smaller are the same to within the rounding.
SMALLEST_SHARE = 1e-9


def with_surface(
    survey: xr.Dataset, measured: xr.DataArray, present: xr.DataArray
) -> Optional[xr.DataArray]:
    """Return the traces without coupling and surface echo, or None if the mean is as good.

    That is so if the heights are equal or not all known, if there are few traces, or if the
    surface echo does not follow the heights.

    Args:
        survey: The survey, with heights.
        measured: Its spectra, lazy ones in whole rows.
        present: Which traces are finite (polarization, y, x).
    """
    present = present.compute().transpose(*SAMPLE_DIMS)
    held = present.any([Y, X])
    if HEIGHT not in survey or not bool(held.any()):
        return None
    height_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).where(present)
    fewest = int(present.sum([Y, X]).where(held).min())
    components = min(fewest // TRACES_PER_COMPONENT, MOST_COMPONENTS)
    spread_m = height_m.std([Y, X]).where(held)
    unknown = present & ~(height_m > 0.0)
    if components < 2 or bool(unknown.any()) or not float(spread_m.min()) > EQUAL_M:
        return None
    model = _Surface(survey[FREQUENCY].values, components)
    # Height, its mean and standard deviation, and delay that was removed, of each trace.
    advance_s = survey[ADVANCE].fillna(0.0) if ADVANCE in survey else xr.zeros_like(height_m)
    mean_m = height_m.mean([Y, X])
    known = [
        lazy.beside(one.broadcast_like(height_m).transpose(*SAMPLE_DIMS), measured)
        for one in (height_m.fillna(mean_m), mean_m, spread_m, advance_s)
    ]
    rows = [[X, FREQUENCY], *([X] for _ in known)]
    sizes = {"one": components + 1, "other": components + 1}
    of_rows = xr.apply_ufunc(
        model.products,
        measured,
        *known,
        input_core_dims=rows,
        output_core_dims=[[FREQUENCY, "one", "other"]],
        dask="parallelized",
        output_dtypes=[np.complex128],
        dask_gufunc_kwargs={"output_sizes": sizes},
    )
    # Row by row, so that the last digit does not depend on the chunks.
    products = of_rows.transpose(POLARIZATION, Y, ...).compute().values.sum(axis=1)
    fitted = [_fitted(*one) for one in zip(products, present.sum([Y, X]).values)]
    if not any(one.any() for one in fitted):
        return None
    # A polarization without a surface echo that follows the heights gets the mean.
    constant = [_constant(one, components) for one in products]
    factors = xr.DataArray(
        np.stack([a if a.any() else b for a, b in zip(fitted, constant)]),
        dims=(POLARIZATION, FREQUENCY, COMPONENT),
    )
    if measured.chunks is not None:
        factors = factors.chunk({POLARIZATION: 1})
    cleaned: xr.DataArray = xr.apply_ufunc(
        model.subtracted,
        measured,
        *known,
        factors.assign_coords({POLARIZATION: measured[POLARIZATION]}),
        input_core_dims=[*rows, [FREQUENCY, COMPONENT]],
        output_core_dims=[[X, FREQUENCY]],
        dask="parallelized",
        output_dtypes=[measured.dtype],
    )
    return cleaned.transpose(*measured.dims)


class _Surface:
    """The components of the background at each frequency."""

    def __init__(self, frequency_hz: np.ndarray, components: int) -> None:
        self._frequency_hz = frequency_hz
        self._components = components

    def products(self, s21: np.ndarray, *known: np.ndarray) -> np.ndarray:
        """Return the products of components and traces with one another, summed over x.

        The traces (..., x, frequency) give (..., frequency, component + 1, component + 1), of
        which the last row and column are those of the traces.
        """
        places, size = s21.shape[:-2], self._components + 1
        found = np.empty((*places, len(self._frequency_hz), size, size), dtype=np.complex128)
        for index in np.ndindex(*places):
            present = np.isfinite(s21[index]).all(axis=-1)
            columns = self._columns([one[index][present] for one in known])
            both = np.concatenate([columns, s21[index][present][None]])
            found[index] = np.einsum("axf,bxf->fab", both.conj(), both)
        return found

    def subtracted(self, s21: np.ndarray, *known_and_factors: np.ndarray) -> np.ndarray:
        """Return the traces (..., x, frequency) without the components times the last argument."""
        *known, factors = known_and_factors
        places = s21.shape[:-2]
        factors = np.broadcast_to(factors, (*places, *factors.shape[-2:]))
        cleaned = np.empty_like(s21)
        for index in np.ndindex(*places):
            columns = self._columns([one[index] for one in known])
            cleaned[index] = s21[index] - np.einsum("axf,fa->xf", columns, factors[index])
        return cleaned

    def _columns(self, known: Sequence[np.ndarray]) -> np.ndarray:
        height_m, mean_m, spread_m, advance_s = (one[:, None] for one in known)
        turn = 2j * np.pi * self._frequency_hz
        constant = np.exp(turn * advance_s)
        surface = constant * np.exp(-turn * two_way_delay_s(height_m)) * mean_m / height_m
        change = surface * (height_m - mean_m) / spread_m
        return np.stack([constant, surface, change])[: self._components]


def _fitted(products: np.ndarray, traces: int) -> np.ndarray:
    """Return the factors (frequency, component) of a polarization; 0 if they gain too little."""
    among, with_traces = products[..., :-1, :-1], products[..., :-1, -1]
    factors = _solved(among, with_traces)
    if traces == 0:
        return np.zeros_like(factors)
    energy = float(np.sum(products[..., -1, -1].real))
    explained = float(np.sum((factors * with_traces.conj()).real))
    by_mean = float(np.sum(np.abs(with_traces[..., 0]) ** 2 / among[..., 0, 0].real))
    chance = (factors.shape[-1] - 1) / traces
    enough = explained - by_mean > LEAST_GAIN * chance * (energy - by_mean)
    return factors if enough else np.zeros_like(factors)


def _constant(products: np.ndarray, components: int) -> np.ndarray:
    """Return the factors (frequency, component) of the mean alone."""
    factors = np.zeros((len(products), components), dtype=np.complex128)
    counts = np.maximum(products[..., 0, 0].real, 1.0)
    factors[:, 0] = products[..., 0, -1] / counts
    return factors


def _solved(among: np.ndarray, with_traces: np.ndarray) -> np.ndarray:
    """Return the factors of least squares (..., component) from the products."""
    shares, vectors = np.linalg.eigh(among)
    held = shares > SMALLEST_SHARE * shares[..., -1:]
    inverse = np.where(held, 1.0 / np.where(held, shares, 1.0), 0.0)
    turned = np.swapaxes(vectors, -1, -2).conj() @ with_traces[..., None]
    solved: np.ndarray = (vectors @ (inverse[..., None] * turned))[..., 0]
    return solved
