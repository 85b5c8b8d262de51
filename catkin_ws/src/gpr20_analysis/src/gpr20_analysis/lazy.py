"""Numbers that are larger than the memory may be: dask arrays in chunks of whole rows."""

from __future__ import annotations

import resource
from typing import Callable

import numpy as np
import psutil
import xarray as xr

from gpr20_analysis.dataset import POLARIZATION, SAMPLE_DIMS, X
from gpr20_analysis.errors import TooLargeError

MIB = 1 << 20


def in_rows(values: xr.DataArray) -> xr.DataArray:
    """Return lazy values (polarization, y, x, any) in chunks of whole rows; others as they are."""
    if values.chunks is None:
        return values
    return values.chunk({POLARIZATION: 1, X: -1, values.dims[-1]: -1})


def beside(small: xr.DataArray, values: xr.DataArray) -> xr.DataArray:
    """Return (polarization, y, x) in the chunks of lazy values.

    Whole, it would be one thing that every chunk needs: dask then computes all of them at once.
    """
    if values.chunks is None:
        return small
    return small.chunk({name: values.chunksizes[name] for name in SAMPLE_DIMS})


def with_neighbours(
    function: Callable[[np.ndarray], np.ndarray], values: xr.DataArray, rows: int
) -> xr.DataArray:
    """Return what a function makes of values that need others beside them.

    Args:
        function: Takes and returns (polarization, y, x, any), of which it may get some rows only.
        values: The same dimensions.
        rows: How many rows before and after its own it has to see.
    """
    if values.chunks is None:
        return values.copy(data=function(values.values))
    lazy = values.data.map_overlap(
        function, depth={1: rows}, boundary="none", dtype=values.dtype, meta=values.data._meta
    )
    return values.copy(data=lazy)


def require_room(values: xr.DataArray, times: float, purpose: str) -> None:
    """Check, before lazy values are loaded whole, that they fit into the memory.

    Args:
        values: What will be loaded; nothing is checked of what is in memory already.
        times: How many times its size the work needs.
        purpose: What it is needed for, for the message.

    Raises:
        TooLargeError: They do not fit.
    """
    needed = times * values.nbytes
    if values.chunks is not None and needed > available_bytes():
        raise TooLargeError(
            f"{purpose} needs {needed / MIB:.0f} MiB of memory, of which "
            f"{available_bytes() / MIB:.0f} MiB are free; take a part with the steps band or "
            "polarization (gpr20 process works on a survey of any size), or another machine"
        )


def available_bytes() -> int:
    """Return what the system can give without swapping, or this process's own limit if less."""
    limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_DATA, resource.RLIMIT_AS))
    own = (limit for limit in limits if limit != resource.RLIM_INFINITY)
    return min([psutil.virtual_memory().available, *own])
