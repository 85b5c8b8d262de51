"""Work on a dask cluster instead of in this process.

A cluster is used where its Client is dask's default scheduler. Work is split so that each part
performs the same operations in the same order as the whole would. Results therefore do not depend
on the workers or on their number.
"""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Callable, Iterator, List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import A_SCAN, POLARIZATION, S21, Y
from gpr20_analysis.errors import AnalysisError, MissingLibraryError, library_missing
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message

if TYPE_CHECKING:
    import dask.array
    from distributed import Client

TIME_LIMIT_S = 10.0
# With fewer parts, workers would be idle while the slowest part is finished.
PARTS_PER_WORKER = 3


@contextlib.contextmanager
def connected(address: Optional[str]) -> Iterator[None]:
    """Make a cluster dask's default scheduler inside a `with`; without an address do nothing.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: No scheduler answers at the address, or the cluster has no workers.
    """
    if not address:
        yield
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingLibraryError(library_missing("distributed", "cluster")) from error
    try:
        client = Client(address, timeout=TIME_LIMIT_S, set_as_default=True)
    except (OSError, ValueError) as error:
        raise AnalysisError(
            Message(
                "no dask scheduler answers at {address} within {limit_s:g} s",
                address=address,
                limit_s=TIME_LIMIT_S,
                details=error,
            ),
            fault=faults.CLUSTER,
        ) from error
    with client:
        if not client.nthreads():
            raise AnalysisError(
                Message(
                    "the cluster at {address} has no workers; start them with "
                    "'dask worker {address}'",
                    address=address,
                ),
                fault=faults.CLUSTER,
            )
        yield


def parts() -> int:
    """Return the number of parts to split work into; 1 without a cluster."""
    client = _client()
    return 1 if client is None else PARTS_PER_WORKER * len(client.nthreads())


def pieces(count: int) -> int:
    """Return the number of pieces of work: small ones in this process, to show the progress."""
    return count if parts() == 1 else parts()


def distribute(
    function: Callable[[Any, Any], Any],
    shared: Any,
    items: Sequence[Any],
    progress: Progress = no_progress,
    threads: int = 1,
) -> List[Any]:
    """Return function(shared, item) of each item, in order, computed by the cluster if any.

    Args:
        function: A function of a module, since it may be called in another process.
        shared: First argument of all calls, sent once.
        items: Second argument of each call.
        progress: Shows the progress.
        threads: Number of threads without a cluster; more than one only helps a function that
            releases the interpreter's lock.
    """
    client = _client()
    if client is not None:
        # Large arguments are sent once, ahead of the tasks that need them.
        common = client.scatter([shared], broadcast=True, hash=False)[0]
        sent = client.scatter(list(items), hash=False)
        tasks = [client.submit(function, common, one, pure=False) for one in sent]
        return [task.result() for task in progress(tasks, len(tasks))]
    if threads == 1:
        return [function(shared, item) for item in progress(items, len(items))]
    with ThreadPoolExecutor(threads) as pool:
        calls = [pool.submit(function, shared, item) for item in items]
        try:
            return [call.result() for call in progress(calls, len(calls))]
        finally:
            # After Ctrl-C only what has begun is finished.
            for call in calls:
                call.cancel()


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0))


def persist(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset whose rows are in the memory of the workers; without a cluster itself."""
    client = _client()
    for name in (S21, A_SCAN):
        if client is not None and name in data and data[name].chunks is None:
            rows = -(-data.sizes[Y] // parts())
            lazy = data[name].chunk({POLARIZATION: 1, Y: rows})
            data = data.assign({name: client.persist(lazy)})
    return data


@contextlib.contextmanager
def fetched(data: xr.Dataset) -> Iterator[xr.Dataset]:
    """Yield a Dataset whose blocks are computed by the workers and written by this process."""
    client = _client()
    if client is None:
        yield data
        return
    import dask.array  # its import takes 0.3 s

    found = data
    for name, values in data.data_vars.items():
        if values.chunks is not None:
            blocks = _Blocks(values.data, client)
            array = dask.array.from_array(blocks, chunks=values.chunks, asarray=False, name=False)
            found = found.assign({name: values.copy(data=array)})
    # Only the workers compute; the local threads wait for them and write.
    threads = dask.config.set(scheduler="threads", num_workers=parts())
    with threads, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Running on a single-machine scheduler")
        yield found


def slices(count: int, number: int) -> List[slice]:
    """Return slices that divide `count` items into parts of about equal size, none empty."""
    edges = np.linspace(0, count, min(number, count) + 1).astype(int)
    return [slice(int(first), int(after)) for first, after in zip(edges[:-1], edges[1:])]


class _Blocks:
    """An array whose blocks are computed on the cluster when they are read."""

    def __init__(self, array: dask.array.Array, client: Client) -> None:
        self.shape, self.dtype, self.ndim = array.shape, array.dtype, array.ndim
        self._array = array
        self._client = client

    def __getitem__(self, place: Any) -> Any:
        return self._client.compute(self._array[place], sync=True)


def _client() -> Optional[Client]:
    if "distributed" not in sys.modules:
        return None
    import dask
    from distributed import default_client

    if dask.config.get("scheduler", None) != "dask.distributed":
        return None

    return default_client()
