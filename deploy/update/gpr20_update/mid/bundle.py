"""A bundle: a folder with packages, their index, checksums and the signature of these."""

from __future__ import annotations

import collections
import hashlib
import os
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, List, Mapping, Tuple

from gpr20_update.errors import UpdateError
from gpr20_update.low.system import BLOCK_BYTES, remove, replace_file, run, shown, sync

SUMS, SIGNATURE, INDEX = "SHA256SUMS", "SHA256SUMS.sig", "Packages"
NAMESPACE = "gpr20-release"
SOFTWARE = "gpr20-software"
MAX_LIST_BYTES, MAX_FILE_BYTES = 4 << 20, 4 << 30
RESERVE_BYTES = 300 << 20
KIB = 1024
_LIMIT_S = 20.0
_SUM = re.compile(r"([0-9a-f]{64})  ([A-Za-z0-9][A-Za-z0-9.+_~%-]*)")
_FIELD = re.compile(r"^([A-Za-z0-9-]+): *(.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Bundle:
    """A bundle whose signature is good; its files are compared when they are copied.

    Attributes:
        folder: Where it is.
        lists: Content of the checksums' file and of its signature.
        sums: SHA-256 of each file, by name.
        packages: The fields of each package, by name.
        signer: Who signed it.
    """

    folder: Path
    lists: Mapping[str, bytes]
    sums: Mapping[str, str]
    packages: Mapping[str, Mapping[str, str]]
    signer: str

    @property
    def version(self) -> str:
        """The version of the software."""
        return self.packages[SOFTWARE]["Version"]

    def files_of(self, names: List[str]) -> List[Path]:
        """Return the files of packages, of those that it has."""
        found = [self.packages[name] for name in names if name in self.packages]
        return [self.folder / Path(one["Filename"]).name for one in found]

    def copy(self, target: Path) -> None:
        """Copy it durably and compare every file on the way; the stick is not needed afterwards.

        Raises:
            UpdateError: A file is missing, changed or unreadable, or the disk too small.
        """
        new = target.with_name(f"{target.name}.new")
        remove(new)
        self._check_space(target.parent)
        new.mkdir(parents=True)
        try:
            for name, digest in self.sums.items():
                replace_file(new / name, _compared(self.folder / name, digest))
            for name, content in self.lists.items():
                replace_file(new / name, [content])
        except (UpdateError, OSError):
            remove(new)
            raise
        remove(target)
        new.rename(target)
        sync(target.parent)

    def _check_space(self, folder: Path) -> None:
        installed = sum(
            int(one.get("Installed-Size", "0")) * KIB
            for name, one in self.packages.items()
            if name.startswith("gpr20-")
        )
        sizes = [self.folder / name for name in self.sums if (self.folder / name).is_file()]
        needed = sum(one.stat().st_size for one in sizes) + installed + RESERVE_BYTES
        free = shutil.disk_usage(str(folder)).free
        if free < needed:
            raise UpdateError(
                f"{folder} has {free >> 20} MB free; the update needs {needed >> 20} MB. Back up "
                "surveys and delete them here, then repeat"
            )

    def check_files(self) -> None:
        """Compare every package of this project with its checksum.

        Raises:
            UpdateError: One is missing or has changed.
        """
        for name, digest in self.sums.items():
            if name.startswith("gpr20-"):
                collections.deque(_compared(self.folder / name, digest), maxlen=0)


def find_bundle(place: Path) -> Path:
    """Return the folder of the bundle: this one, or the only one in it named gpr20-VERSION.

    Raises:
        UpdateError: There is none, or more than one.
    """
    if not place.is_dir():
        raise UpdateError(f"{shown(place)} is no folder; mount the stick and name its folder")
    if (place / SUMS).is_file():
        return place
    found = sorted(one.parent for one in place.glob(f"gpr20-*/{SUMS}"))
    if len(found) == 1:
        return found[0]
    if not found:
        raise UpdateError(
            f"{shown(place)} holds no bundle: a folder gpr20-VERSION with the file {SUMS}; name "
            "the folder where the stick is mounted"
        )
    names = ", ".join(shown(one.name) for one in found)
    raise UpdateError(f"{shown(place)} holds several bundles: {names}; name the folder of one")


def open_bundle(folder: Path, signers: Path) -> Bundle:
    """Return a bundle with a good signature.

    Args:
        folder: Of the bundle.
        signers: The signers that are accepted, as ssh-keygen reads them.

    Raises:
        UpdateError: It is not signed by one of them, or not as gpr20-update needs it.
    """
    lists = {name: _read(folder / name) for name in (SUMS, SIGNATURE)}
    signer = _signer(folder, lists, signers)
    sums = dict(_sums(folder, lists[SUMS].decode("ascii", "replace")))
    index = b"".join(_compared(folder / INDEX, sums.get(INDEX, "")))
    packages = {one["Package"]: one for one in _stanzas(index.decode("utf-8", "replace"))}
    if not {"Version", "Architecture"} <= set(packages.get(SOFTWARE, {})):
        raise UpdateError(f"the bundle {shown(folder)} has no package {SOFTWARE}; make it again")
    return Bundle(folder, lists, sums, packages, signer)


def _signer(folder: Path, lists: Mapping[str, bytes], signers: Path) -> str:
    if not signers.is_file():
        raise UpdateError(
            f"{signers} is missing, so no signature is accepted; write the line of who signs the "
            "releases there"
        )
    with tempfile.TemporaryDirectory(prefix="gpr20_update_") as private:
        signature = Path(private, SIGNATURE)
        signature.write_bytes(lists[SIGNATURE])
        same = ("-s", str(signature))
        keygen = ("ssh-keygen", "-Y")
        names = run(*keygen, "find-principals", *same, "-f", str(signers), limit_s=_LIMIT_S)
        if names.status != 0 or not names.output.strip():
            raise UpdateError(
                f"{shown(folder / SUMS)} is not signed by anyone in {signers} "
                f"({names.last_lines}); install releases of your own maintainers only, or write "
                "the line of who signed it there"
            )
        name = names.output.splitlines()[0]
        chosen = ("-f", str(signers), "-I", name, "-n", NAMESPACE)
        checked = run(*keygen, "verify", *same, *chosen, limit_s=_LIMIT_S, text=lists[SUMS])
    if checked.status != 0:
        raise UpdateError(
            f"{shown(folder / SUMS)} is not as {shown(name)} signed it, or not signed as a release "
            f"({checked.last_lines}); copy the bundle to the stick again"
        )
    return name


def _sums(folder: Path, text: str) -> Iterator[Tuple[str, str]]:
    for line in text.splitlines():
        found = _SUM.fullmatch(line)
        if found is None:
            raise UpdateError(
                f"{shown(folder / SUMS)} has the line {shown(line[:80])!r}; allowed is a SHA-256, "
                "two spaces and a name without folders. Make the bundle again"
            )
        yield found.group(2), found.group(1)


def _stanzas(text: str) -> Iterator[Dict[str, str]]:
    for stanza in text.split("\n\n"):
        fields = dict(_FIELD.findall(stanza))
        if "Package" in fields:
            yield fields


def _read(path: Path) -> bytes:
    content = b"".join(_blocks(path, MAX_LIST_BYTES))
    if len(content) > MAX_LIST_BYTES:
        raise UpdateError(f"{shown(path)} is larger than {MAX_LIST_BYTES >> 20} MB; make it again")
    return content


def _blocks(path: Path, most_bytes: int) -> Iterator[bytes]:
    """Yield the content of a file; not much more than so many bytes."""
    try:
        # A pipe does not block.
        with open(os.open(str(path), os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            while file.tell() <= most_bytes:
                block = file.read(BLOCK_BYTES)
                if not block:
                    return
                yield block
    except OSError as error:
        raise UpdateError(
            f"{shown(path)} cannot be read: {error.strerror}; plug the stick in again and repeat, "
            "or copy the bundle to it again"
        ) from error


def _compared(path: Path, digest: str) -> Iterator[bytes]:
    """Yield the content of a file; raise at its end if it is not what was signed."""
    found = hashlib.sha256()
    for block in _blocks(path, MAX_FILE_BYTES):
        found.update(block)
        yield block
    if found.hexdigest() != digest:
        raise UpdateError(
            f"{shown(path)} is not as it was signed: it is damaged or was changed; copy the bundle "
            "to the stick again"
        )
