"""The configuration, and what the window remembers, as they were before an update."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path

from gpr20_update.system import Paths, UpdateError, remove, run, sync

# Everything of theirs is below these folders.
FOLDERS = ("etc/gpr20", "var/lib/gpr20/.config/gpr20")
CONFIGURATION = "/etc/gpr20"
KEPT_BACKUPS = 10
_OTHER_FOLDER = re.compile(r'^GPR20_CONFIG="?([^"\n]*)', re.MULTILINE)
_LIMIT_S = 300.0


def keep(paths: Paths, version: str) -> Path:
    """Copy the folders to where the copies are; delete old ones; return the copy.

    Raises:
        UpdateError: The configuration is elsewhere, or cannot be copied.
    """
    settings = paths.settings
    text = settings.read_text("utf-8", "replace") if settings.is_file() else ""
    for other in _OTHER_FOLDER.findall(text):
        if not f"{os.path.normpath(other)}/".startswith(f"{CONFIGURATION}/"):
            raise UpdateError(
                f"GPR20_CONFIG is {other} in {settings}; an update keeps what is in "
                f"{CONFIGURATION}. Move the configuration there"
            )
    now = time.strftime("%Y%m%dT%H%M%S", time.gmtime())
    kept = paths.backups / f"{now}Z_{version}"
    remove(kept)
    for folder in FOLDERS:
        if (paths.root / folder).is_dir():
            _copy(paths.root / folder, kept / folder)
    for old in sorted(paths.backups.iterdir())[:-KEPT_BACKUPS]:
        remove(old)
    return kept


def apply(kept: Path, paths: Paths) -> None:
    """Put copies in the place of the folders, each whole and durable; may be repeated."""
    for folder in FOLDERS:
        if (kept / folder).is_dir():
            own = paths.root / folder
            new, old = (own.with_name(f".{own.name}.{one}") for one in ("new", "old"))
            remove(new)
            _copy(kept / folder, new)
            if own.exists():
                remove(old)
                os.replace(str(own), str(old))
            os.replace(str(new), str(own))
            sync(own.parent)
            remove(old)


def _copy(source: Path, target: Path) -> None:
    """Copy a folder with owners, rights and links; return when the copy is durable."""
    target.parent.mkdir(parents=True, exist_ok=True)
    for command in (["cp", "--archive", str(source)], ["sync", "--file-system"]):
        ended = run(*command, str(target), limit_s=_LIMIT_S)
        if ended.status != 0:
            raise UpdateError(f"{source} cannot be copied to {target}: {ended.last_lines}")
