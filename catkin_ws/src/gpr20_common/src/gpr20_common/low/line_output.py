"""Lines that are seen when they are said."""

from __future__ import annotations

import io
import sys
from typing import Optional, TextIO


def enable_line_buffering(stream: Optional[TextIO] = None) -> None:
    """Let a stream pass each line on when it ends.

    Python keeps back several kilobytes of what goes into a file, a pipe or the journal, and rospy
    does not flush: the log of a node would lag by hours and end before the lines that say why.

    Args:
        stream: Standard output if None. One that is no buffered file needs nothing.
    """
    chosen = sys.stdout if stream is None else stream
    if isinstance(chosen, io.TextIOWrapper):
        chosen.reconfigure(line_buffering=True)
