"""A bundle: a folder with packages, their index, checksums and the signature of these."""

from __future__ import annotations

import contextlib
import hashlib
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, List, Mapping

from gpr20_update.low.system import UpdateError, remove, run, sync

SUMS, SIGNATURE, INDEX = "SHA256SUMS", "SHA256SUMS.sig", "Packages"
NAMESPACE = "gpr20-release"
SOFTWARE = "gpr20-software"
RESERVE_BYTES = 300 << 20
_BLOCK_BYTES = 1 << 20
_LIMIT_S = 20.0
_FIELD = re.compile(r"^([A-Za-z0-9-]+): *(.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Bundle:
    """A bundle whose signature is good; its files are compared when they are copied.

    Attributes:
        folder: Where it is.
        sums: SHA-256 of each file, by name.
        packages: The fields of each package, by name.
        signer: Who signed it.
    """

    folder: Path
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
        """Copy it durably and compare every file; the stick is not needed afterwards.

        Raises:
            UpdateError: A file is missing, changed or unreadable, or the disk too small.
        """
        new = target.with_name(f"{target.name}.new")
        remove(new)
        self._check_space(target.parent)
        new.mkdir(parents=True)
        try:
            with _stick():
                for name in (*self.sums, SUMS, SIGNATURE):
                    shutil.copyfile(str(self.folder / name), str(new / name))
                    sync(new / name)
            _compare(new, self.sums, self.folder)
        except UpdateError:
            remove(new)
            raise
        sync(new)
        remove(target)
        new.rename(target)
        sync(target.parent)

    def _check_space(self, folder: Path) -> None:
        own = [one for name, one in self.packages.items() if name.startswith("gpr20-")]
        installed = sum(int(one.get("Installed-Size", "0")) << 10 for one in own)
        with _stick():
            copied = sum((self.folder / name).stat().st_size for name in self.sums)
        free, needed = shutil.disk_usage(str(folder)).free, copied + installed + RESERVE_BYTES
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
        own = {name: one for name, one in self.sums.items() if name.startswith("gpr20-")}
        _compare(self.folder, own, self.folder)


def find_bundle(place: Path) -> Path:
    """Return the folder of the bundle: this one, or the only one in it named gpr20-VERSION.

    Raises:
        UpdateError: There is none, or more than one.
    """
    found = [place] if (place / SUMS).is_file() else []
    found = found or sorted(one.parent for one in place.glob(f"gpr20-*/{SUMS}"))
    if len(found) == 1:
        return found[0]
    names = ", ".join(one.name for one in found) or "no bundle, a folder gpr20-VERSION"
    raise UpdateError(f"{place} holds {names}; name the folder of the stick, or of one bundle")


def open_bundle(folder: Path, signers: Path) -> Bundle:
    """Return a bundle with a good signature.

    Args:
        folder: Of the bundle.
        signers: The signers that are accepted, as ssh-keygen reads them.

    Raises:
        UpdateError: It is not signed by one of them, or damaged.
    """
    with _stick():
        text = (folder / SUMS).read_bytes().decode("ascii", "replace")
        signer = _signer(folder, text, signers)
        sums = {name: digest for digest, name in (one.split("  ") for one in text.splitlines())}
        index = (folder / INDEX).read_bytes()
    if hashlib.sha256(index).hexdigest() != sums[INDEX]:
        raise _damaged(folder / INDEX)
    stanzas = [dict(_FIELD.findall(one)) for one in index.decode().split("\n\n")]
    return Bundle(folder, sums, {one["Package"]: one for one in stanzas if one}, signer)


def _signer(folder: Path, text: str, signers: Path) -> str:
    same = ("-s", str(folder / SIGNATURE), "-f", str(signers))
    found = run("ssh-keygen", "-Y", "find-principals", *same, limit_s=_LIMIT_S)
    if found.status != 0 or not found.output.strip():
        raise UpdateError(
            f"{folder / SUMS} is not signed by anyone in {signers} ({found.last_lines}); install "
            "releases of your own maintainers only, or write the line of who signed it there"
        )
    name = found.output.splitlines()[0]
    how = ("-n", NAMESPACE, "-I", name)
    checked = run("ssh-keygen", "-Y", "verify", *same, *how, limit_s=_LIMIT_S, text=text)
    if checked.status != 0:
        raise UpdateError(
            f"{folder / SUMS} is not as {name} signed it, or not signed as a release "
            f"({checked.last_lines}); copy the bundle to the stick again"
        )
    return name


def _compare(folder: Path, sums: Mapping[str, str], source: Path) -> None:
    for name, wanted in sums.items():
        digest = hashlib.sha256()
        with _stick(), (folder / name).open("rb") as file:
            for block in iter(lambda: file.read(_BLOCK_BYTES), b""):
                digest.update(block)
        if digest.hexdigest() != wanted:
            raise _damaged(source / name)


def _damaged(path: Path) -> UpdateError:
    return UpdateError(
        f"{path} is not as it was signed: it is damaged or was changed; copy the bundle to the "
        "stick again"
    )


@contextlib.contextmanager
def _stick() -> Iterator[None]:
    """Say what to do about a file that cannot be read or copied."""
    try:
        yield
    except OSError as error:
        raise UpdateError(
            f"{error.filename or error} cannot be copied or read: {error.strerror}; plug the stick "
            "in again and repeat, or copy the bundle to it again"
        ) from error
