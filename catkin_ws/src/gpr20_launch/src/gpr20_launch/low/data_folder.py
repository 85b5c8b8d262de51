"""Whether the folder of the surveys can be written."""

from __future__ import annotations

import tempfile
from pathlib import Path


def try_to_write(folder: Path, mode: int) -> None:
    """Make the folder if it is missing, and a file in it, which is removed again.

    Args:
        folder: The folder.
        mode: Its mode, if it is made.

    Raises:
        OSError: That is not possible.
    """
    if not folder.is_dir():
        folder.mkdir(parents=True)
        folder.chmod(mode)  # whatever the umask
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".gpr20-", suffix=".tmp") as file:
        file.write(b"survey")
        file.flush()
