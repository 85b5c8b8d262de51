"""Backups of the configuration, and of what the window remembers.

A backup is a tar.gz, whose end has a checksum. It never holds a private key, nor who may sign a
release.
"""

from __future__ import annotations

import gzip
import io
import os
import pwd
import re
import tarfile
import time
import zlib
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Tuple

from gpr20_update.low.system import Paths, UpdateError, replace_file, sync

# Everything of theirs below these folders.
OWNERS = ("root", "gpr20")
FOLDERS = ("etc/gpr20", "var/lib/gpr20/.config/gpr20")
CONFIGURATION = "/etc/gpr20"
# Every computer has it, so each backup does.
SETTINGS = "etc/gpr20/environment"
# The anchor of trust does not come from a file that nobody has signed.
_LEFT_OUT = frozenset({"etc/gpr20/release_signers"})
_PRIVATE = re.compile(rb"-----BEGIN [A-Z0-9 ]*PRIVATE KEY-----")
_OTHER_FOLDER = re.compile(r'^GPR20_CONFIG="?([^"\n]*)', re.MULTILINE)
RIGHTS = 0o755
# The last ones that were made before an update or a restore.
KEPT_BACKUPS = 10


class Content(NamedTuple):
    """One file of a backup."""

    data: bytes
    mode: int
    owner: str


Files = Dict[str, Content]
"""The files of a backup, by their path without the first slash."""


def take(paths: Paths) -> Tuple[Files, List[str]]:
    """Return all files of a backup of this computer, and the links and pipes that it cannot hold.

    Raises:
        UpdateError: The configuration is elsewhere.
    """
    files: Files = {}
    others = []
    for path in _found(paths):
        # What a link leads to may be no configuration.
        if path.is_symlink() or not path.is_file():
            others.append(str(path))
        else:
            files[str(path.relative_to(paths.root))] = _content(path)
    settings = files.get(SETTINGS, Content(b"", 0, "")).data.decode("utf-8", "replace")
    for folder in _OTHER_FOLDER.findall(settings):
        if not f"{os.path.normpath(folder)}/".startswith(f"{CONFIGURATION}/"):
            raise UpdateError(
                f"GPR20_CONFIG is {folder} in {paths.settings}; a backup holds what is in "
                f"{CONFIGURATION}. Move the configuration there"
            )
    private = {name for name, one in files.items() if _PRIVATE.search(one.data)}
    left_out = private | {f"{name}.pub" for name in private} | _LEFT_OUT
    return {name: one for name, one in files.items() if name not in left_out}, others


def write(files: Files, path: Path) -> None:
    """Write a backup durably, one that `read` accepts."""
    if SETTINGS not in files:
        raise UpdateError(f"/{SETTINGS} is missing, or no file; write it again (docs/install.md)")
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz", format=tarfile.PAX_FORMAT) as tar:
        for name, one in sorted(files.items()):
            member = tarfile.TarInfo(name)
            member.size, member.mode, member.uname = len(one.data), one.mode, one.owner
            tar.addfile(member, io.BytesIO(one.data))
    replace_file(path, packed.getvalue())


def keep(paths: Paths, version: str) -> Tuple[Path, List[str]]:
    """Make a backup of this computer where the others are; delete old ones.

    Returns:
        The backup, and what `take` has left out.
    """
    files, others = take(paths)
    paths.backups.mkdir(exist_ok=True)
    now_ns = time.time_ns()
    begin = time.strftime("%Y%m%dT%H%M%S", time.gmtime(now_ns // 10**9))
    path = paths.backups / f"{begin}.{now_ns % 10**9:09}Z_{version}.tar.gz"
    write(files, path)
    for old in sorted(paths.backups.glob("*.tar.gz"))[:-KEPT_BACKUPS]:
        old.unlink()
    return path, others


def read(path: Path) -> Files:
    """Return the files of a backup, each as it was written.

    Raises:
        UpdateError: It is none, or it is damaged.
    """
    try:
        # To the end, where its checksum is.
        with gzip.open(str(path)) as packed:
            data = packed.read()
        with tarfile.open(fileobj=io.BytesIO(data), mode="r:") as tar:
            files = dict(_members(tar, path))
    except (OSError, EOFError, zlib.error, tarfile.TarError) as error:
        raise UpdateError(f"{path} is no backup, or is damaged: {error}") from error
    if SETTINGS not in files:
        raise UpdateError(f"{path} is no backup of gpr20-update: it holds no {SETTINGS}")
    return files


def apply(files: Files, paths: Paths) -> None:
    """Make the files of this computer those of a backup, each durably; may be repeated.

    Private keys and the signers stay as they are. What the backup does not have is deleted.
    """
    now, _others = take(paths)
    for name in sorted(set(now) - set(files)):
        (paths.root / name).unlink()
        sync((paths.root / name).parent)
    for name, one in sorted(files.items()):
        if now.get(name) != one:
            _put(paths.root / name, one, paths)


def _found(paths: Paths) -> Iterator[Path]:
    """Yield everything but folders."""
    for folder in FOLDERS:
        for path in sorted((paths.root / folder).rglob("*")):
            if path.is_symlink() or not path.is_dir():
                yield path


def _content(path: Path) -> Content:
    with open(os.open(str(path), os.O_RDONLY | os.O_NOFOLLOW), "rb") as file:
        status = os.fstat(file.fileno())
        users = {one.pw_uid: one.pw_name for one in pwd.getpwall()}
        owner = users.get(status.st_uid, str(status.st_uid))
        return Content(file.read(), status.st_mode & RIGHTS, owner)


def _members(tar: tarfile.TarFile, path: Path) -> Iterator[Tuple[str, Content]]:
    for member in tar:
        inside = member.name.startswith(tuple(f"{one}/" for one in FOLDERS))
        # Each file has one name, so that none that is left out comes under another.
        plain = os.path.normpath(member.name) == member.name
        file = tar.extractfile(member) if member.isreg() else None
        if file is None or not inside or not plain or member.name in _LEFT_OUT:
            raise UpdateError(
                f"{path} holds {member.name!r}; allowed are files below {' and '.join(FOLDERS)}"
            )
        yield member.name, Content(file.read(), member.mode & RIGHTS, member.uname)


def _put(path: Path, content: Content, paths: Paths) -> None:
    """Write a file, with the folders above it that are missing, for its owner."""
    # A backup gives files to nobody else.
    users = {one.pw_name: one for one in pwd.getpwall() if one.pw_name in OWNERS}
    user = users.get(content.owner, pwd.getpwuid(0))
    owner = (user.pw_uid, user.pw_gid)
    for folder in reversed([one for one in path.parents if not one.exists()]):
        folder.mkdir(mode=0o755)
        os.chown(str(folder), *owner)
        sync(folder.parent)
    if path.parent.resolve() != paths.root.resolve() / path.parent.relative_to(paths.root):
        raise UpdateError(f"{path.parent} is a link; a restore writes into folders only")
    replace_file(path, content.data, content.mode, owner)
