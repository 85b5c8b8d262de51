"""The end of a window that hangs, so that whatever started it starts another one."""

from __future__ import annotations

import faulthandler

# Far longer than anything that the window does between two events [s].
LIMIT_S = 30.0


class HangGuard:
    """Ends this process with a traceback of every thread unless `beat` is called again and again.

    The time is measured outside Python: it also ends a process whose interpreter hangs.
    """

    def __init__(self, limit_s: float = LIMIT_S) -> None:
        self._limit_s = limit_s

    def beat(self) -> None:
        """Say that the window still handles its events."""
        faulthandler.dump_traceback_later(self._limit_s, exit=True)

    def end(self) -> None:
        """Expect no further beat."""
        faulthandler.cancel_dump_traceback_later()
