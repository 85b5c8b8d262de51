"""Work on the numbers of a survey in blocks of whole rows, whether they lie in memory or are lazy.

A lazy survey is a dask array larger than the memory may be: each function sees a few rows of it at
a time. What is in memory is one block.
"""

from __future__ import annotations

from typing import Any, Callable, List, Optional, Union

import dask
import dask.array
import numpy as np
import xarray as xr

from gpr20_analysis.errors import TooLargeError
from gpr20_analysis.low.memory import available_bytes
from gpr20_analysis.mid.dataset import POLARIZATION, SAMPLE_DIMS, X

Array = Union[np.ndarray, dask.array.Array]
COMPLEX = np.dtype(np.complex128)
MIB = 1 << 20
SUMMED_AT_ONCE = 8


def is_lazy(values: Array) -> bool:
    """Say whether numbers are computed when they are looked at."""
    return isinstance(values, dask.array.Array)


def in_rows(values: xr.DataArray) -> xr.DataArray:
    """Return lazy values (polarization, y, x, any) in chunks of whole rows; others as they are."""
    if values.chunks is None:
        return values
    return values.chunk({POLARIZATION: 1, X: -1, values.dims[-1]: -1})


def beside(small: xr.DataArray, values: xr.DataArray) -> xr.DataArray:
    """Return (polarization, y, x) lazy and in the rows of lazy values, so that both meet lazily."""
    if values.chunks is None:
        return small
    return small.chunk({name: values.chunksizes[name] for name in SAMPLE_DIMS})


def each(
    function: Callable[[np.ndarray], np.ndarray], values: Array, last: Optional[int] = None
) -> Array:
    """Return what a function makes of each block.

    Args:
        function: Takes and returns complex numbers of the same rows.
        values: (..., y, x, any).
        last: Length of the last dimension of the result, if it is another one.
    """
    if not isinstance(values, dask.array.Array):
        return function(values)
    chunks = values.chunks if last is None else (*values.chunks[:-1], (last,))
    return values.map_blocks(function, dtype=COMPLEX, chunks=chunks)


def each_with_neighbours(
    function: Callable[[np.ndarray], np.ndarray], volume: Array, rows: int
) -> Array:
    """The same for (y, x, any), where the function sees some rows before and after its own too."""
    if not isinstance(volume, dask.array.Array):
        return function(volume)
    return volume.map_overlap(function, depth={0: rows, 1: 0, 2: 0}, boundary="none", dtype=COMPLEX)


def gather(function: Callable[[np.ndarray], Any], values: Array) -> List[Any]:
    """Return the small things that a function makes of each block, computed, in order of rows."""
    if not isinstance(values, dask.array.Array):
        return [function(values)]
    blocks = values.to_delayed().ravel()
    return list(dask.compute(*[dask.delayed(function)(block) for block in blocks]))


def total(function: Callable[[np.ndarray], np.ndarray], values: Array) -> np.ndarray:
    """Return the sum of what a function makes of each block, which may be as large as a block."""
    if not isinstance(values, dask.array.Array):
        return function(values)
    blocks = values.to_delayed().ravel()
    found: Any = 0
    for first in range(0, len(blocks), SUMMED_AT_ONCE):
        made = [dask.delayed(function)(block) for block in blocks[first : first + SUMMED_AT_ONCE]]
        found = sum(dask.compute(*made), found)
    summed: np.ndarray = found
    return summed


def require_room(values: xr.DataArray, times: float, purpose: str) -> None:
    """Check, before lazy values are loaded whole, that they fit into the memory.

    Args:
        values: What will be loaded; nothing is checked of what is in memory already.
        times: How many times its size the work needs.
        purpose: What it is needed for, for the message.

    Raises:
        TooLargeError: They do not fit.
    """
    needed, free = times * values.nbytes, available_bytes()
    if values.chunks is not None and needed > free:
        raise TooLargeError(
            f"{purpose} needs {needed / MIB:.0f} MiB of memory, of which {free / MIB:.0f} MiB are "
            "free; take a part with the steps band or polarization (gpr20 process works on a "
            "survey of any size), or another machine"
        )


def stack(volumes: List[Array]) -> Array:
    """Return (polarization, y, x, any) of the volumes of all polarizations."""
    if any(is_lazy(volume) for volume in volumes):
        return dask.array.stack(volumes)
    return np.stack(volumes)
