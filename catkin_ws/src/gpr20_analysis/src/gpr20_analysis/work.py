"""Long work: its progress for callers that show it, the processors, and the memory it needs."""

from __future__ import annotations

import os
import resource
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Iterable, List, Optional, Sequence, TypeVar

import psutil

from gpr20_analysis.errors import TooLargeError
from gpr20_common.message import Message

Item = TypeVar("Item")
Progress = Callable[[Iterable[Item], Optional[int]], Iterable[Item]]
"""Takes an iterable and its length, if known, and shows how much of it was used."""

MIB = 1 << 20


def no_progress(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
    """Show no progress."""
    return items


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0))


def on_threads(
    function: Callable[[Any], Any], items: Sequence[Any], progress: Progress
) -> List[Any]:
    """Return function(item) of each item, in order, computed by a thread per processor.

    Args:
        function: Releases the interpreter's lock for most of its work.
        items: What it is called with.
        progress: Shows the progress.
    """
    with ThreadPoolExecutor(processors()) as pool:
        calls = [pool.submit(function, item) for item in items]
        try:
            return [call.result() for call in progress(calls, len(calls))]
        finally:
            # After Ctrl-C only what has begun is finished.
            for call in calls:
                call.cancel()


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
                "free; select a part with the steps band or polarization, or use a larger machine",
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
