"""Numbers of a survey in a temporary file, for surveys that are large beside the memory."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

import numpy as np

EMPTY = complex(math.nan, math.nan)
ROWS_PER_WRITE = 1024


class Spool:
    """Makes arrays of complex128: in memory up to a size, in a temporary file above it."""

    def __init__(self, limit_bytes: int, folder: Optional[Path] = None) -> None:
        """Make nothing yet.

        Args:
            limit_bytes: The largest array that is made in memory [bytes].
            folder: Where temporary files are put; None for the system's place.
        """
        self._limit_bytes = limit_bytes
        self._folder = folder
        self._keeper: Optional[tempfile.TemporaryDirectory] = None
        self.path: Optional[Path] = None
        """The file of the array that was made last; None if it is in memory."""

    def allocate(self, shape: Tuple[int, int]) -> np.ndarray:
        """Return an array of NaN.

        Raises:
            OSError: There is no space for the temporary file.
        """
        if shape[0] * shape[1] * np.dtype(np.complex128).itemsize <= self._limit_bytes:
            self.path = None
            return np.full(shape, EMPTY, np.complex128)
        if self._keeper is None:
            folder = None if self._folder is None else str(self._folder)
            self._keeper = tempfile.TemporaryDirectory(prefix="gpr20_", dir=folder)
        handle, name = tempfile.mkstemp(dir=self._keeper.name)
        rows = np.full((min(ROWS_PER_WRITE, shape[0]), shape[1]), EMPTY, np.complex128)
        # Written rather than mapped and filled: a full disk is an error here, not a crash later.
        with open(handle, "wb") as stream:
            for start in range(0, shape[0], ROWS_PER_WRITE):
                stream.write(rows[: shape[0] - start].tobytes())
        self.path = Path(name)
        return np.memmap(name, np.complex128, "r+", shape=shape)

    def stored(self, shape: Tuple[int, ...]) -> Optional[SpooledArray]:
        """Return the array made last as one read where it is looked at; None if in memory."""
        return None if self.path is None else SpooledArray(self.path, shape, self._keeper)


def flush(values: np.ndarray) -> None:
    """Write what was changed in a mapped array to its file."""
    mapped: Any = values
    while mapped is not None and not hasattr(mapped, "flush"):
        mapped = getattr(mapped, "base", None)
    if mapped is not None:
        mapped.flush()


class SpooledArray:
    """An array in a file; it may be sent to other processes that see the same file."""

    dtype = np.dtype(np.complex128)

    def __init__(self, path: Path, shape: Tuple[int, ...], keeper: Any) -> None:
        """Take the file.

        Args:
            path: Of complex128, the last dimension the fastest.
            shape: What of it is the array.
            keeper: Kept alive as long as the array: it removes the file at its end.
        """
        self.path, self.shape, self.ndim = path, shape, len(shape)
        self._keeper = keeper

    def __getitem__(self, place: Any) -> np.ndarray:
        mapped = np.memmap(str(self.path), np.complex128, "r", shape=self.shape)
        return np.array(mapped[place])

    def __getstate__(self) -> Dict[str, Any]:
        # The file belongs to the process that made it.
        return {**self.__dict__, "_keeper": None}
