"""Whether the folder of the surveys can be written."""

from __future__ import annotations

import tempfile
from pathlib import Path


def try_to_write(folder: Path) -> None:
    """Make the folder if it is missing, and a file in it, which is removed again.

    Raises:
        OSError: That is not possible.
    """
    folder.mkdir(parents=True, exist_ok=True, mode=0o750)
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".gpr20-", suffix=".tmp") as file:
        file.write(b"survey")
        file.flush()
