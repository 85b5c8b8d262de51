"""The file in which the log is kept."""

from __future__ import annotations

import logging
from logging.handlers import RotatingFileHandler
from pathlib import Path

LARGEST_BYTES = 100 * 1024 * 1024
KEPT_FILES = 10


class LogFile:
    """A text file that is put aside when it has become large; the oldest are deleted.

    Args:
        path: The file; its folder is made if it is missing.
        largest_bytes: Size at which the next file is begun [bytes].
        kept_files: How many full files are kept beside it.
    """

    def __init__(
        self, path: Path, largest_bytes: int = LARGEST_BYTES, kept_files: int = KEPT_FILES
    ) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._handler = RotatingFileHandler(
            str(path), maxBytes=largest_bytes, backupCount=kept_files, encoding="utf-8"
        )

    def write(self, line: str) -> None:
        """Append a line."""
        # The handler takes records; every other field of this one is unused.
        self._handler.emit(logging.LogRecord("", logging.INFO, "", 0, line, None, None))

    def close(self) -> None:
        """Close the file."""
        self._handler.close()
