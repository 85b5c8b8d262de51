"""A progress bar on a terminal, by tqdm."""

from __future__ import annotations

import shutil
from typing import Optional, TextIO

from tqdm import tqdm

from gpr20_common.terminal_text import printable

# Without the remaining time as tqdm estimates it: the main control knows it better.
BAR_FORMAT = "{desc}{percentage:3.0f}% |{bar}| {n_fmt}/{total_fmt}{postfix}"


class TerminalBar:
    """One bar at the bottom of the terminal, lines above it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._bar: Optional[tqdm] = None

    def write(self, line: str) -> None:
        """Write a line above the bar."""
        tqdm.write(printable(line), file=self._stream)
        self._stream.flush()

    def show(self, done: int, total: int, before: str, behind: str) -> None:
        """Move the bar, between two texts; the first call makes it."""
        if self._bar is None:
            self._bar = tqdm(total=0, bar_format=BAR_FORMAT, file=self._stream, ncols=_columns())
        self._bar.ncols = _columns()
        self._bar.total = total
        self._bar.n = done
        self._bar.set_description_str(printable(before), refresh=False)
        self._bar.set_postfix_str(printable(behind), refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        """Leave the bar as it is and go to the next line."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def _columns() -> int:
    # Some terminals report no width; tqdm would take that for zero and drop the bar's format.
    return shutil.get_terminal_size().columns
