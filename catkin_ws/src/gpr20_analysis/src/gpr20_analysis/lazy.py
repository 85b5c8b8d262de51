"""Arrays that may be larger than the memory: dask arrays in chunks of whole rows."""

from __future__ import annotations

import resource
from typing import Callable

import numpy as np
import psutil
import xarray as xr

from gpr20_analysis.dataset import POLARIZATION, SAMPLE_DIMS, X
from gpr20_analysis.errors import TooLargeError
from gpr20_common.message import Message

MIB = 1 << 20


def in_rows(values: xr.DataArray) -> xr.DataArray:
    """Return lazy values (polarization, y, x, any) in chunks of whole rows, others unchanged."""
    if values.chunks is None:
        return values
    return values.chunk({POLARIZATION: 1, X: -1, values.dims[-1]: -1})


def beside(small: xr.DataArray, values: xr.DataArray) -> xr.DataArray:
    """Return (polarization, y, x) in the chunks of lazy values.

    As a single array it would be an input of every chunk, and dask would compute all at once.
    """
    if values.chunks is None:
        return small
    return small.chunk({name: values.chunksizes[name] for name in SAMPLE_DIMS})


def with_neighbours(
    function: Callable[[np.ndarray], np.ndarray], values: xr.DataArray, rows: int
) -> xr.DataArray:
    """Return the result of a function that needs neighbouring rows.

    Args:
        function: Takes and returns (polarization, y, x, any); it may get some of the rows only.
        values: The same dimensions.
        rows: Number of rows that it needs before and after each row.
    """
    if values.chunks is None:
        return values.copy(data=function(values.values))
    lazy = values.data.map_overlap(
        function, depth={1: rows}, boundary="none", dtype=values.dtype, meta=values.data._meta
    )
    return values.copy(data=lazy)


def require_room(values: xr.DataArray, times: float, purpose: Message) -> None:
    """Check that lazy values fit into the memory before they are loaded completely.

    Args:
        values: Values to load; those already in memory are not checked.
        times: Memory needed, in multiples of their size.
        purpose: What needs them, for the message.

    Raises:
        TooLargeError: They do not fit.
    """
    if values.chunks is not None:
        require_bytes(times * values.nbytes, purpose)


def require_bytes(needed: float, purpose: Message) -> None:
    """Check that memory is available.

    Args:
        needed: Memory needed [bytes].
        purpose: What needs it, for the message.

    Raises:
        TooLargeError: There is less.
    """
    if needed > available_bytes():
        raise TooLargeError(
            Message(
                "{purpose} needs {needed_mib:.0f} MiB of memory, but only {free_mib:.0f} MiB are "
                "free; select a part with the steps band or polarization (gpr20 process works on "
                "surveys of any size), or use a larger machine",
                purpose=purpose,
                needed_mib=needed / MIB,
                free_mib=available_bytes() / MIB,
            )
        )


def available_bytes() -> int:
    """Return the memory available without swapping, or this process's limit if it is less."""
    limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_DATA, resource.RLIMIT_AS))
    own = (limit for limit in limits if limit != resource.RLIM_INFINITY)
    return min([psutil.virtual_memory().available, *own])
