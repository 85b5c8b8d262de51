"""Work on a dask cluster instead of in this process.

A cluster is used where its Client is dask's default scheduler. Work is cut so that a part does the
very same operations as the whole does for it, in the same order; so results do not depend on who
works nor on how many.
"""

from __future__ import annotations

import contextlib
import warnings
from typing import TYPE_CHECKING, Any, Callable, Iterator, List, Optional, Sequence

import dask
import dask.array
import numpy as np
import xarray as xr

from gpr20_analysis.dataset import A_SCAN, POLARIZATION, S21, Y
from gpr20_analysis.errors import AnalysisError, MissingLibraryError

if TYPE_CHECKING:
    from distributed import Client

TIME_LIMIT_S = 10.0
# Fewer would leave a worker idle while the slowest part is finished.
PARTS_PER_WORKER = 3


@contextlib.contextmanager
def connected(address: Optional[str]) -> Iterator[None]:
    """Make a cluster dask's default scheduler while this is open; without an address do nothing.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: Nobody answers there, or the cluster has no workers.
    """
    if not address:
        yield
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingLibraryError(
            "--scheduler needs dask's distributed: pip install 'gpr20_analysis[cluster]'"
        ) from error
    try:
        client = Client(address, timeout=TIME_LIMIT_S, set_as_default=True)
    except (OSError, ValueError) as error:
        raise AnalysisError(
            f"no dask scheduler answers at {address} within {TIME_LIMIT_S:g} s: {error}"
        ) from error
    with client:
        if not client.nthreads():
            raise AnalysisError(
                f"the cluster at {address} has no workers; start some with 'dask worker {address}'"
            )
        yield


def parts() -> int:
    """Return into how many parts a work should be cut; 1: it should not."""
    client = _client()
    return 1 if client is None else PARTS_PER_WORKER * len(client.nthreads())


def distribute(
    function: Callable[[Any, Any], Any], shared: Any, things: Sequence[Any]
) -> List[Any]:
    """Return function(shared, thing) of each thing, in their order, computed by the cluster.

    Args:
        function: Of a module; it may be called in another process.
        shared: What all calls need, sent once.
        things: What they differ in.
    """
    client = _client()
    if client is None:
        return [function(shared, thing) for thing in things]
    # Large arguments are sent once, ahead of the tasks that need them.
    common = client.scatter([shared], broadcast=True, hash=False)[0]
    sent = client.scatter(list(things), hash=False)
    tasks = [client.submit(function, common, one, pure=False) for one in sent]
    found: List[Any] = client.gather(tasks)
    return found


def spread(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset whose numbers are lazy, some rows at each worker; as it is without any."""
    client = _client()
    for name in (S21, A_SCAN):
        if client is not None and name in data and data[name].chunks is None:
            rows = -(-data.sizes[Y] // parts())
            lazy = data[name].chunk({POLARIZATION: 1, Y: rows})
            data = data.assign({name: client.persist(lazy)})
    return data


@contextlib.contextmanager
def fetched(data: xr.Dataset) -> Iterator[xr.Dataset]:
    """Lend a Dataset whose blocks the workers compute, while this process writes them."""
    client = _client()
    if client is None:
        yield data
        return
    lent = data
    for name, values in data.data_vars.items():
        if values.chunks is not None:
            blocks = _Blocks(values.data, client)
            array = dask.array.from_array(blocks, chunks=values.chunks, asarray=False, name=False)
            lent = lent.assign({name: values.copy(data=array)})
    # Only the workers compute; the threads here wait for them, and write.
    here = dask.config.set(scheduler="threads", num_workers=parts())
    with here, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Running on a single-machine scheduler")
        yield lent


def slices(count: int, number: int) -> List[slice]:
    """Return slices that cut so many things into parts of about equal size, none empty."""
    edges = np.linspace(0, count, min(number, count) + 1).astype(int)
    return [slice(int(first), int(after)) for first, after in zip(edges[:-1], edges[1:])]


class _Blocks:
    """An array of which what is looked at is computed on the cluster."""

    def __init__(self, array: dask.array.Array, client: Client) -> None:
        self.shape, self.dtype, self.ndim = array.shape, array.dtype, array.ndim
        self._array = array
        self._client = client

    def __getitem__(self, place: Any) -> Any:
        return self._client.compute(self._array[place], sync=True)


def _client() -> Optional[Client]:
    if dask.config.get("scheduler", None) != "dask.distributed":
        return None
    from distributed import default_client

    return default_client()
