"""The argument --scheduler: work on the workers of a dask cluster instead of in this process."""

from __future__ import annotations

import argparse
import contextlib
import warnings
from typing import TYPE_CHECKING, Any, Callable, Iterator, List, Protocol, Sequence

import dask
import dask.array
import xarray as xr

from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_analysis.mid.dataset import A_SCAN, S21, SAMPLE_DIMS, Y
from gpr20_analysis.mid.workers import ThisProcess, Workers, slices

if TYPE_CHECKING:
    from distributed import Client

TIME_LIMIT_S = 10.0
# Fewer would leave a worker idle while the slowest part is finished.
PARTS_PER_WORKER = 3


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare the argument."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package and, for surveys of more than 1 GiB, see the same files",
    )


class Machines(Workers, Protocol):
    """Who works for a command."""

    def spread(self, data: xr.Dataset) -> xr.Dataset:
        """Return a Dataset whose numbers lie where steps will be computed on them."""

    def fetched(self, data: xr.Dataset) -> contextlib.AbstractContextManager[xr.Dataset]:
        """Lend a Dataset whose numbers are computed as they are looked at, to be written here."""


class Here(ThisProcess):
    """This process alone."""

    def spread(self, data: xr.Dataset) -> xr.Dataset:
        """Return the Dataset as it is."""
        return data

    def fetched(self, data: xr.Dataset) -> contextlib.AbstractContextManager[xr.Dataset]:
        """Lend the Dataset as it is."""
        return contextlib.nullcontext(data)


class Cluster:
    """The workers of a dask cluster."""

    def __init__(self, client: Client, count: int) -> None:
        """Take a connection to so many workers."""
        self.parts = PARTS_PER_WORKER * count
        self._client = client

    def map(
        self, function: Callable[[Any, Any], Any], shared: Any, things: Sequence[Any]
    ) -> List[Any]:
        """Return function(shared, thing) of each thing, in their order."""
        # Large arguments are sent once, ahead of the tasks that need them.
        common = self._client.scatter([shared], broadcast=True, hash=False)[0]
        sent = self._client.scatter(list(things), hash=False)
        tasks = [self._client.submit(function, common, one, pure=False) for one in sent]
        found: List[Any] = self._client.gather(tasks)
        return found

    def spread(self, data: xr.Dataset) -> xr.Dataset:
        """Return a Dataset whose numbers are lazy, some rows at each worker."""
        for name in (S21, A_SCAN):
            if name in data and data[name].chunks is None:
                values = data[name].transpose(*SAMPLE_DIMS, ...)
                data = data.assign({name: values.copy(data=self._sent(values))})
        return data

    def _sent(self, values: xr.DataArray) -> dask.array.Array:
        rows = slices(values.sizes[Y], self.parts)
        blocks = [volume[part] for volume in values.values for part in rows]
        sent = iter(self._client.scatter(blocks, hash=False))
        return dask.array.stack(
            [
                dask.array.concatenate(
                    [
                        dask.array.from_delayed(next(sent), volume[part].shape, volume.dtype)
                        for part in rows
                    ]
                )
                for volume in values.values
            ]
        )

    @contextlib.contextmanager
    def fetched(self, data: xr.Dataset) -> Iterator[xr.Dataset]:
        """Lend a Dataset whose blocks the workers compute, while this process writes them."""
        lent = data
        for name, values in data.data_vars.items():
            if values.chunks is not None:
                blocks = _Blocks(values.data, self._client)
                array = dask.array.from_array(
                    blocks, chunks=values.chunks, asarray=False, name=False
                )
                lent = lent.assign({name: values.copy(data=array)})
        # Only the workers compute; the threads here wait for them, and write.
        here = dask.config.set(scheduler="threads", num_workers=self.parts)
        with here, warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Running on a single-machine scheduler")
            yield lent


class _Blocks:
    """An array of which what is looked at is computed on the cluster."""

    def __init__(self, array: dask.array.Array, client: Client) -> None:
        self.shape, self.dtype, self.ndim = array.shape, array.dtype, array.ndim
        self._array = array
        self._client = client

    def __getitem__(self, place: Any) -> Any:
        return self._client.compute(self._array[place], sync=True)


@contextlib.contextmanager
def machines(chosen: argparse.Namespace) -> Iterator[Machines]:
    """Yield who does heavy work: this process, or the named cluster.

    While it is open dask computes lazy surveys on the cluster too.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: Nobody answers there, or the cluster has no workers.
    """
    if not chosen.scheduler:
        yield Here()
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingLibraryError(
            "--scheduler needs dask's distributed: pip install 'gpr20_analysis[cluster]'"
        ) from error
    try:
        client = Client(chosen.scheduler, timeout=TIME_LIMIT_S, set_as_default=True)
    except (OSError, ValueError) as error:
        raise AnalysisError(
            f"no dask scheduler answers at {chosen.scheduler} within {TIME_LIMIT_S:g} s: {error}"
        ) from error
    with client:
        count = len(client.scheduler_info()["workers"])
        if count == 0:
            raise AnalysisError(
                f"the cluster at {chosen.scheduler} has no workers; start some with "
                f"'dask worker {chosen.scheduler}'"
            )
        yield Cluster(client, count)
