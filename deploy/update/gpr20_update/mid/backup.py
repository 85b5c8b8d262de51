"""Backups of the configuration, and of what the window remembers.

A backup is a tar.gz, whose end has a checksum. It begins with `backup.json`: version, computer and
members of the group gpr20. It never holds a private key, nor who may sign a release.
"""

from __future__ import annotations

import gzip
import io
import json
import os
import pwd
import re
import socket
import stat
import tarfile
import time
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping, Tuple

from gpr20_update.errors import UpdateError
from gpr20_update.low.paths import Paths
from gpr20_update.low.system import replace_file, shown, sync

FIRST = "backup.json"
FORMAT = "gpr20-backup-1"
# Everything of theirs below these folders.
OWNERS = ("root", "gpr20")
FOLDERS = ("etc/gpr20", "var/lib/gpr20/.config/gpr20")
CONFIGURATION = "/etc/gpr20"
GROUP = "gpr20"
# The anchor of trust does not come from a file that nobody has signed.
_LEFT_OUT = frozenset({"etc/gpr20/release_signers"})
_PRIVATE = re.compile(rb"-----BEGIN [A-Z0-9 ]*PRIVATE KEY-----")
_OTHER_FOLDER = re.compile(r'^GPR20_CONFIG="?([^"\n]*)', re.MULTILINE)
RIGHTS = 0o755
MAX_FILE_BYTES = 16 << 20
MAX_BYTES = 64 << 20
# The last ones that were made before an update or a restore.
KEPT_BACKUPS = 10


@dataclass(frozen=True)
class Content:
    """One file of a backup."""

    data: bytes
    mode: int
    owner: str


@dataclass(frozen=True)
class Backup:
    """A backup that was read and is intact.

    Attributes:
        files: The files, by their path without the first slash.
        version: The version of the software that it is from.
        people: Members of the group gpr20.
        left_out: Links, pipes and sockets that are in the folders, but not in the backup.
    """

    files: Mapping[str, Content]
    version: str
    people: Tuple[str, ...]
    left_out: Tuple[str, ...] = ()


def take(paths: Paths, version: str) -> Backup:
    """Return everything that a backup of this computer holds.

    Raises:
        UpdateError: The configuration is elsewhere, or a file cannot be read.
    """
    settings = paths.settings
    text = settings.read_text("utf-8", "replace") if settings.is_file() else ""
    for folder in _OTHER_FOLDER.findall(text):
        if not f"{os.path.normpath(folder)}/".startswith(f"{CONFIGURATION}/"):
            raise UpdateError(
                f"GPR20_CONFIG is {shown(folder)} in {settings}; a backup holds what is in "
                f"{CONFIGURATION}. Move the configuration there"
            )
    found = list(_found(paths))
    # What a link leads to may be no configuration.
    files = {str(one.relative_to(paths.root)): _content(one) for one in found if _is_file(one)}
    others = tuple(str(one) for one in found if not _is_file(one))
    private = {name for name, one in files.items() if _PRIVATE.search(one.data)}
    left_out = private | {f"{name}.pub" for name in private} | _LEFT_OUT
    kept = {name: one for name, one in files.items() if name not in left_out}
    return Backup(kept, version, _people(paths), others)


def write(backup: Backup, path: Path) -> None:
    """Write a backup durably."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz", format=tarfile.PAX_FORMAT) as tar:
        _add(tar, FIRST, Content(_description(backup), 0o600, "root"))
        for name, one in sorted(backup.files.items()):
            _add(tar, name, one)
    replace_file(path, [packed.getvalue()])


def keep(paths: Paths, version: str) -> Tuple[Path, Backup]:
    """Make a backup of this computer where the others are; delete old ones."""
    taken = take(paths, version)
    paths.backups.mkdir(exist_ok=True)
    now_ns = time.time_ns()
    begin = time.strftime("%Y%m%dT%H%M%S", time.gmtime(now_ns // 10**9))
    path = paths.backups / f"{begin}.{now_ns % 10**9:09}Z_{version}.tar.gz"
    write(taken, path)
    for old in sorted(paths.backups.glob("*.tar.gz"))[:-KEPT_BACKUPS]:
        old.unlink()
    return path, taken


def read(path: Path) -> Backup:
    """Return a backup whose every file is as it was written.

    Raises:
        UpdateError: It is none, or it is damaged.
    """
    try:
        # To the end, where its checksum is.
        with gzip.open(str(path)) as packed:
            data = packed.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise UpdateError(f"{shown(path)} holds more than {MAX_BYTES >> 20} MB")
        with tarfile.open(fileobj=io.BytesIO(data), mode="r:") as tar:
            files = dict(_members(tar, path))
    except (OSError, EOFError, zlib.error, tarfile.TarError) as error:
        why = shown(getattr(error, "strerror", None) or error)
        raise UpdateError(f"{shown(path)} is no backup, or is damaged: {why}") from error
    described = _read_description(files.pop(FIRST, Content(b"", 0, "")).data, path)
    return Backup(files, str(described["version"]), tuple(map(str, described["people"])))


def apply(backup: Backup, paths: Paths) -> None:
    """Make the files of this computer those of a backup, each durably; may be repeated.

    Private keys and the signers stay as they are. What the backup does not have is deleted.
    """
    now = take(paths, "").files
    for name in sorted(set(now) - set(backup.files)):
        (paths.root / name).unlink()
        sync((paths.root / name).parent)
    for name, one in sorted(backup.files.items()):
        if now.get(name) != one:
            _put(paths.root / name, one, paths)


def _found(paths: Paths) -> Iterator[Path]:
    """Yield everything but folders."""
    for folder in (paths.root / one for one in FOLDERS):
        yield from (
            one for one in sorted(folder.rglob("*")) if one.is_symlink() or not one.is_dir()
        )


def _is_file(path: Path) -> bool:
    return stat.S_ISREG(path.lstat().st_mode)


def _content(path: Path) -> Content:
    with open(os.open(str(path), os.O_RDONLY | os.O_NOFOLLOW), "rb") as file:
        status = os.fstat(file.fileno())
        if status.st_size > MAX_FILE_BYTES:
            raise UpdateError(
                f"{shown(path)} has {status.st_size >> 20} MB; a file of the configuration has "
                f"{MAX_FILE_BYTES >> 20} MB at most. Move it away"
            )
        return Content(file.read(), status.st_mode & RIGHTS, _name_of(status.st_uid))


def _name_of(user: int) -> str:
    return next((one.pw_name for one in pwd.getpwall() if one.pw_uid == user), str(user))


def _people(paths: Paths) -> Tuple[str, ...]:
    lines = (paths.root / "etc/group").read_text("utf-8", "replace").splitlines()
    members = [line.split(":")[3] for line in lines if line.startswith(f"{GROUP}:")]
    return tuple(one for one in ",".join(members).split(",") if one)


def _description(backup: Backup) -> bytes:
    record = {
        "format": FORMAT,
        "version": backup.version,
        "computer": socket.gethostname(),
        "people": backup.people,
    }
    return json.dumps(record, indent=2).encode()


def _read_description(data: bytes, path: Path) -> Dict[str, Any]:
    try:
        record = json.loads(data)
        if record["format"] == FORMAT:
            return {**record, "people": list(record["people"]), "version": record["version"]}
    except (ValueError, KeyError, TypeError):
        pass
    raise UpdateError(f"{shown(path)} is no backup of gpr20-update, or it begins with damage")


def _add(tar: tarfile.TarFile, name: str, content: Content) -> None:
    member = tarfile.TarInfo(name)
    member.size, member.mode, member.uname = len(content.data), content.mode, content.owner
    tar.addfile(member, io.BytesIO(content.data))


def _members(tar: tarfile.TarFile, path: Path) -> Iterator[Tuple[str, Content]]:
    for member in tar:
        inside = member.name == FIRST or member.name.startswith(tuple(f"{one}/" for one in FOLDERS))
        # Each file has one name, so that none that is left out comes under another.
        plain = os.path.normpath(member.name) == member.name
        if not (member.isreg() and inside and plain) or member.name in _LEFT_OUT:
            raise UpdateError(
                f"{shown(path)} holds {shown(member.name)!r}; allowed are files below "
                f"{' and '.join(FOLDERS)}"
            )
        file = tar.extractfile(member)
        assert file is not None
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
        raise UpdateError(f"{shown(path.parent)} is a link; a restore writes into folders only")
    replace_file(path, [content.data], content.mode, owner)
