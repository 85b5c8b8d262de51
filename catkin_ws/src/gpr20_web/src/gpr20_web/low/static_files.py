"""The files of the pages, read once: what is not among them cannot be asked for."""

from __future__ import annotations

import mimetypes
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Dict

# Not from the computer's table, which may have another one.
KINDS = {".js": "text/javascript", ".svg": "image/svg+xml"}


@dataclass(frozen=True)
class StaticFile:
    """A file of the pages, with its media type and a tag of its content."""

    content: bytes
    kind: str
    tag: str


def read_files(folder: Path) -> Dict[str, StaticFile]:
    """Return the files of a folder by their paths on the page."""
    return {
        f"/{path.relative_to(folder).as_posix()}": _read(path)
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _read(path: Path) -> StaticFile:
    kind = KINDS.get(path.suffix) or mimetypes.guess_type(path.name)[0]
    content = path.read_bytes()
    if kind is not None and kind.startswith("text/"):
        kind = f"{kind}; charset=UTF-8"
    return StaticFile(
        content, kind or "application/octet-stream", f'"{sha256(content).hexdigest()[:32]}"'
    )
