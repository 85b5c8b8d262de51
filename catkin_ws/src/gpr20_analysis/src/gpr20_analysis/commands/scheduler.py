"""The argument --scheduler: work on the workers of a dask cluster instead of in this process."""

from __future__ import annotations

import argparse
import contextlib
from typing import Iterator

from gpr20_analysis.errors import AnalysisError, MissingLibraryError

TIME_LIMIT_S = 10.0


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare the argument."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package and see the same files",
    )


@contextlib.contextmanager
def cluster(chosen: argparse.Namespace) -> Iterator[bool]:
    """Make dask compute on the cluster that was named, and say whether one was.

    Raises:
        MissingLibraryError: dask's distributed is not installed.
        AnalysisError: Nobody answers there.
    """
    if not chosen.scheduler:
        yield False
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
        yield True
