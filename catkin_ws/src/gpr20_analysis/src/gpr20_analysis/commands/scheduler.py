"""The argument --scheduler: work on the workers of a dask cluster instead of in this process."""

from __future__ import annotations

import argparse
import contextlib
from typing import TYPE_CHECKING, Any, Callable, Iterator, List, Sequence

from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_analysis.mid.workers import THIS_PROCESS, Workers

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
        "package and see the same files",
    )


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


@contextlib.contextmanager
def workers(chosen: argparse.Namespace) -> Iterator[Workers]:
    """Yield who does heavy work: this process, or the named cluster.

    While it is open dask computes lazy surveys on the cluster too.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: Nobody answers there, or the cluster has no workers.
    """
    if not chosen.scheduler:
        yield THIS_PROCESS
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
