"""How much memory something takes, in a process that does nothing else."""

from __future__ import annotations

import multiprocessing
import tracemalloc
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Callable


def peak_bytes(work: Callable[..., object], *given: Any) -> int:
    """Return how much memory a function of a module takes at most [bytes]; its errors are raised.

    In a process of its own: here, other threads would be counted too.
    """
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_measured, work, given).result()


def _measured(work: Callable[..., object], given: Any) -> int:
    tracemalloc.start()
    work(*given)
    return tracemalloc.get_traced_memory()[1]
