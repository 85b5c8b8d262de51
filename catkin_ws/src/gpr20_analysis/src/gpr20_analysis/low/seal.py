"""A checksum that goes with a file or folder, so that changes on the disk are seen.

HDF5 and Zarr have none by themselves, and a byte changed in what HDF5 keeps of its own can make its
library crash. A file gets a last line after its content, which HDF5's readers do not look at; a
folder gets one more file, with a line for each of the others.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Dict, Iterator, List

from gpr20_analysis.errors import UnreadableFileError

WORD = b"\n#gpr20 sha256 "
LINE_BYTES = len(WORD) + 64 + 1
FOLDER_SEAL = ".gpr20-sha256"
BLOCK_BYTES = 1 << 20


def seal(path: Path) -> None:
    """Add the checksum.

    Args:
        path: File or folder that has none.

    Raises:
        OSError: The disk refused.
    """
    if path.is_dir():
        lines = [f"{digest} {name}" for name, digest in sorted(_folder(path).items())]
        (path / FOLDER_SEAL).write_text("\n".join([*lines, ""]), encoding="utf-8")
        return
    line = WORD + _digest(path, path.stat().st_size).encode("ascii") + b"\n"
    with path.open("ab") as stream:
        stream.write(line)


def is_intact(path: Path) -> bool:
    """Say whether the checksum was found and is right; without one nothing is known.

    Raises:
        UnreadableFileError: What is there is not what was sealed.
        OSError: It cannot be read.
    """
    return _is_folder_intact(path) if path.is_dir() else _is_file_intact(path)


def _is_file_intact(path: Path) -> bool:
    size = path.stat().st_size - LINE_BYTES
    if size < 0:
        return False
    with path.open("rb") as stream:
        stream.seek(size)
        line = stream.read()
    if not line.startswith(WORD):
        return False
    if line != WORD + _digest(path, size).encode("ascii") + b"\n":
        raise UnreadableFileError(
            f"{path} is damaged: its bytes are not those that were written (SHA-256); make it anew "
            "from the survey"
        )
    return True


def _is_folder_intact(path: Path) -> bool:
    sealed = path / FOLDER_SEAL
    if not sealed.exists():
        return False
    lines = sealed.read_text(encoding="utf-8", errors="replace").splitlines()
    told = {name: digest for digest, _, name in (line.partition(" ") for line in lines)}
    found = _folder(path)
    wrong: List[str] = [name for name in told if found.get(name) != told[name]]
    wrong += [name for name in found if name not in told]
    if wrong:
        raise UnreadableFileError(
            f"{path} is damaged: {len(wrong)} of its files are not those that were written "
            f"(SHA-256), e.g. {min(wrong)}; make it anew from the survey"
        )
    return True


def _folder(path: Path) -> Dict[str, str]:
    return {
        one.relative_to(path).as_posix(): _digest(one, one.stat().st_size)
        for one in path.rglob("*")
        if one.is_file() and one != path / FOLDER_SEAL
    }


def _digest(path: Path, size: int) -> str:
    found = hashlib.sha256()
    for block in _blocks(path, size):
        found.update(block)
    return found.hexdigest()


def _blocks(path: Path, size: int) -> Iterator[bytes]:
    with path.open("rb") as stream:
        while size > 0:
            block = stream.read(min(size, BLOCK_BYTES))
            if not block:
                return
            size -= len(block)
            yield block
