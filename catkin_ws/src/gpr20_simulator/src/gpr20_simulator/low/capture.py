"""Keeping the exact bytes that were sent."""

from __future__ import annotations

import itertools
from pathlib import Path

NUMBER_DIGITS = 6
NUMBERED = "[0-9]" * NUMBER_DIGITS + "_*.bin"


class CaptureFolder:
    """Writes each reply to a file of its own, such as `000001_sdat.bin`.

    Args:
        folder: Where; it is made if it is not there, and added to if it is.

    Raises:
        OSError: The folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        used = [int(one.name[:NUMBER_DIGITS]) for one in folder.glob(NUMBERED)]
        self._numbers = itertools.count(max(used, default=0) + 1)

    def save(self, kind: str, data: bytes) -> None:
        """Write one reply; the number in its name is higher than that of all before.

        Raises:
            OSError: The file cannot be written.
        """
        name = f"{next(self._numbers):0{NUMBER_DIGITS}d}_{kind}.bin"
        with (self._folder / name).open("xb") as file:
            file.write(data)
