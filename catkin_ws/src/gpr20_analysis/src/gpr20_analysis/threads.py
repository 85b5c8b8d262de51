"""Work of one image on the processors of this computer."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, List, Sequence

from gpr20_analysis.progress import Progress


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
