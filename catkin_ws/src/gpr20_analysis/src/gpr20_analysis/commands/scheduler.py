"""The argument --scheduler: work on the workers of a dask cluster instead of in this process."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any, Callable, Iterator, List, Sequence

from gpr20_analysis.errors import AnalysisError, MissingLibraryError

TIME_LIMIT_S = 10.0

Each = Callable[[Callable[[Any], Any], Sequence[Any]], List[Any]]


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare the argument."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package and see the same files",
    )


def in_turn(function: Callable[[Any], Any], things: Sequence[Any]) -> List[Any]:
    """Apply a function to one thing after another, in this process."""
    return [function(one) for one in things]


@contextlib.contextmanager
def workers(chosen: argparse.Namespace) -> Iterator[Each]:
    """Yield what applies a function to each of several things: here, or on the named cluster.

    While it is open dask computes lazy surveys on the cluster too.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: Nobody answers there.
    """
    if not chosen.scheduler:
        yield in_turn
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

        def on_cluster(function: Callable[[Any], Any], things: Sequence[Any]) -> List[Any]:
            # Large arguments are sent once, ahead of the task that needs them.
            sent = client.scatter(list(things))
            return client.gather(client.map(function, sent, pure=False))

        yield on_cluster
