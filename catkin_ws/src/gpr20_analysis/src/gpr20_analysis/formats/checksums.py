"""SHA-256 of a file or folder, since HDF5 and Zarr do not check everything that they read.

A changed byte in the internal structures of HDF5 can make its library crash. A file gets a last
line after its content, which readers of HDF5 ignore; a folder gets a file with a line for each
other file.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Dict

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_survey.files.file_sums import PIECE_BYTES, regular_files, sum_of_file

WORD = b"\n#gpr20 sha256 "
LINE_BYTES = len(WORD) + 64 + 1
SUMS_FILE = ".gpr20-sha256"


def add_checksum(path: Path) -> None:
    """Add the checksum to a file or folder that has none.

    Raises:
        OSError: It cannot be written.
    """
    if path.is_dir():
        lines = [f"{digest} {name}\n" for name, digest in _sums(path).items()]
        (path / SUMS_FILE).write_text("".join(lines), encoding="utf-8")
    else:
        line = WORD + sum_of_file(path).sha256.encode("ascii") + b"\n"
        with path.open("ab") as stream:
            stream.write(line)


def has_checksum(path: Path) -> bool:
    """Return whether there is a checksum, which is then correct.

    Raises:
        UnreadableFileError: The content is not what was written.
        OSError: It cannot be read.
    """
    if path.is_dir():
        return _check_folder(path)
    size = path.stat().st_size - LINE_BYTES
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        stream.seek(max(size, 0))
        line = stream.read()
        if size < 0 or not line.startswith(WORD):
            return False
        stream.seek(0)
        for start in range(0, size, PIECE_BYTES):
            digest.update(stream.read(min(PIECE_BYTES, size - start)))
    if line != WORD + digest.hexdigest().encode("ascii") + b"\n":
        raise UnreadableFileError(
            Message(
                "{path} is damaged: its SHA-256 has changed; create it again from the survey",
                path=path,
            ),
            fault=faults.FILE_DAMAGED,
        )
    return True


def _check_folder(path: Path) -> bool:
    if not (path / SUMS_FILE).exists():
        return False
    lines = (path / SUMS_FILE).read_text(encoding="utf-8", errors="replace").splitlines()
    listed = {name: digest for digest, _, name in (line.partition(" ") for line in lines)}
    found = _sums(path)
    wrong = [name for name in {**listed, **found} if listed.get(name) != found.get(name)]
    if wrong:
        raise UnreadableFileError(
            Message(
                "{path} is damaged: the SHA-256 of {count} of its files has changed, e.g. {file}; "
                "create it again from the survey",
                path=path,
                count=len(wrong),
                file=min(wrong),
            ),
            fault=faults.FILE_DAMAGED,
        )
    return True


def _sums(path: Path) -> Dict[str, str]:
    names = (name for name in regular_files(path) if name != SUMS_FILE)
    return {name: sum_of_file(path / name).sha256 for name in names}
