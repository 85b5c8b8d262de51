"""The package: what a stick offers, what is installed, install another version, return to one.

A stick holds a signed repository of apt (scripts/stick.sh). apt compares signature and sums.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import time
from pathlib import Path
from typing import Dict, Iterator, List
from urllib.parse import quote

from gpr20_update.system import (
    Ended,
    Paths,
    UpdateError,
    is_taken,
    remove,
    replace_file,
    run,
    sync,
)

PACKAGE = "gpr20"
RESERVE_BYTES = 300 << 20
QUERY_LIMIT_S = 60.0
INSTALL_LIMIT_S = 1800.0
LOCK_LIMIT_S = 120.0
_POLL_S = 0.2
_INSTALLED = "installed"
# Nobody is asked; a configuration file that somebody changed stays as it is.
_QUIET = {"DEBIAN_FRONTEND": "noninteractive", "NEEDRESTART_SUSPEND": "1"}
_KEEP = ("--force-confdef", "--force-confold")


class Packages:
    """The package of this computer."""

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def installed(self) -> str:
        """Return the version that is installed.

        Raises:
            UpdateError: None is, or it is between two states.
        """
        state = self._states().get(PACKAGE, "")
        if not state.startswith(f"{_INSTALLED} "):
            raise UpdateError(
                f"{PACKAGE} is not installed as a whole ({state or 'not there'}); run dpkg "
                "--configure -a, or install it (docs/install.md)"
            )
        return state.split(" ")[1]

    def is_newer(self, version: str, than: str) -> bool:
        """Return whether a version is newer than another one."""
        asked = ("dpkg", "--compare-versions", version, "gt", than)
        return run(*asked, limit_s=QUERY_LIMIT_S).status == 0

    def offered(self, stick: Path) -> str:
        """Return the version on a stick, whose signature is good.

        Raises:
            UpdateError: It is damaged, or not signed with the key of this computer.
        """
        key = self._paths.key
        if not key.is_file():
            raise UpdateError(
                f"{key} is missing, the key of those who sign releases for this robot; write the "
                "public key of your maintainers there (docs/maintain.md)"
            )
        for folder in (self._paths.lists, self._paths.archives):
            remove(folder)
            (folder / "partial").mkdir(parents=True)
        source = f"deb [signed-by={key}] copy:{quote(str(stick))} ./\n"
        replace_file(self._paths.sources, source.encode())
        self._apt("update", else_say=f"{stick} cannot be read, or is not signed with {key}")
        found = self._apt("madison", PACKAGE, program="apt-cache").output.split("|")
        if len(found) < 2:
            raise UpdateError(f"{stick} has no package {PACKAGE} for this kind of computer")
        return found[1].strip()

    def fetch(self, version: str) -> None:
        """Copy from the stick what this computer needs of it, durably; it is not needed afterwards.

        Raises:
            UpdateError: A file is missing, changed or unreadable, the disk too small, or the
                version cannot be installed on this system.
        """
        wanted = (f"{PACKAGE}={version}", "--reinstall", "--download-only")
        self._apt(
            *("install", *wanted),
            else_say=f"version {version} cannot be copied from the stick, or cannot be installed "
            "here; plug the stick in again and repeat, have it made again, or use one for this "
            "kind of computer and this version of Debian or Ubuntu",
        )
        (package,) = self._paths.archives.glob(f"{PACKAGE}_*.deb")
        field = ("dpkg-deb", "--field", str(package), "Installed-Size")
        needed = (int(run(*field, limit_s=QUERY_LIMIT_S).output) << 10) + RESERVE_BYTES
        free = shutil.disk_usage(str(self._paths.archives)).free
        if free < needed:
            raise UpdateError(
                f"{self._paths.archives} has {free >> 20} MB free; the update needs "
                f"{needed >> 20} MB. Back up surveys and delete them here, then repeat"
            )
        kept = self._kept(version)
        with contextlib.suppress(FileNotFoundError):
            kept.unlink()
        os.link(str(package), str(kept))
        run("sync", "--file-system", str(kept), limit_s=INSTALL_LIMIT_S)
        replace_file(kept.with_suffix(".sha256"), _digest(kept).encode())

    def kept(self) -> List[str]:
        """Return the versions to which this computer can return."""
        return sorted(one.stem for one in self._paths.kept.glob("*.deb"))

    def check_kept(self, version: str) -> None:
        """Refuse to begin anything from which no way leads back.

        Raises:
            UpdateError: The package of a version is not kept, or damaged.
        """
        package = self._kept(version)
        with contextlib.suppress(OSError):
            if package.with_suffix(".sha256").read_text(encoding="ascii") == _digest(package):
                return
        raise UpdateError(
            f"the package of version {version} is not kept in {package.parent}, or damaged, so "
            "there would be no way back; run gpr20-update with the stick of that version first, "
            "which keeps it and installs nothing"
        )

    def forget(self, *needed: str) -> None:
        """Delete the packages that no return needs: all but those of some versions."""
        for version in set(self.kept()) - set(needed):
            self._kept(version).unlink()
            self._kept(version).with_suffix(".sha256").unlink()
        remove(self._paths.archives)

    def install(self, version: str) -> None:
        """Install a version that was fetched, with what it needs.

        Raises:
            UpdateError: It failed in the middle.
        """
        wanted = ("install", f"{PACKAGE}={version}", "--no-download")
        self._apt(*wanted, else_say="the installation failed")

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Hold the lock that every program holds which calls dpkg; wait for another one.

        A dpkg whose caller was killed lives on and holds only its own lock.

        Raises:
            UpdateError: Another one holds them for too long.
        """
        folder, deadline_s = self._paths.dpkg, time.monotonic() + LOCK_LIMIT_S
        with (folder / "lock-frontend").open("ab") as frontend, (folder / "lock").open("ab") as own:
            while not (is_taken(frontend) and is_taken(own)):
                if time.monotonic() > deadline_s:
                    raise UpdateError(
                        f"another program has installed packages for {LOCK_LIMIT_S:.0f} s ({folder}"
                        " is locked); wait for its end and repeat, with gpr20-update --continue if "
                        "--status says UNFINISHED"
                    )
                time.sleep(_POLL_S)
            # dpkg takes it itself.
            fcntl.lockf(own, fcntl.LOCK_UN)
            yield

    def put_back(self, version: str) -> None:
        """Install a kept version, whatever state an installation has left; may be repeated.

        Nobody else may install meanwhile, see `alone`.

        Raises:
            UpdateError: It failed.
        """
        # What is half done of the distribution's packages is done; none of them returns.
        begun = [one for one, state in self._states().items() if _INSTALLED not in state.split()]
        files = [
            str(file)
            for name in set(begun) - {PACKAGE}
            for file in self._paths.archives.glob(f"{name}_*.deb")
        ]
        ended = _dpkg("--install", str(self._kept(version)), *files)
        if ended.status != 0:
            ended = _dpkg("--configure", "--pending")
        if self._states().get(PACKAGE) != f"{_INSTALLED} {version}":
            raise UpdateError(f"version {version} could not be installed again: {ended.last_lines}")

    def use_slot(self, version: str) -> None:
        """Let services and commands use a release that is in a slot at once, if it is.

        It need not wait for dpkg, nor for a package that can be read.
        """
        for slot in sorted(self._paths.slots.glob("?")) if self.slot_version() != version else ():
            file = slot / "release"
            if file.is_file() and file.read_text(encoding="utf-8").strip() == version:
                new = self._paths.current.with_name("current.new")
                if new.is_symlink():
                    new.unlink()
                new.symlink_to(f"slots/{slot.name}")
                os.replace(str(new), str(self._paths.current))
                sync(new.parent)
                return

    def slot_version(self) -> str:
        """Return the version of the release that is used."""
        try:
            return (self._paths.current / "release").read_text(encoding="utf-8").strip()
        except OSError as error:
            return f"unknown ({error.strerror})"

    def _kept(self, version: str) -> Path:
        return self._paths.kept / f"{version}.deb"

    def _states(self) -> Dict[str, str]:
        """Return state and version of each package that dpkg knows, by name."""
        asked = ("dpkg-query", "-W", "-f", "${Package} ${db:Status-Status} ${Version}\\n")
        ended = run(*asked, limit_s=QUERY_LIMIT_S)
        if ended.status != 0:
            raise UpdateError(f"dpkg does not answer: {ended.last_lines}")
        lines = [one.split(" ", 1) for one in ended.output.splitlines()]
        return {name: state for name, state in lines}

    def _apt(self, *words: str, program: str = "apt-get", else_say: str = "") -> Ended:
        """Run a program of apt with the stick as the only source.

        Raises:
            UpdateError: It failed; this is said, with what it printed.
        """
        options = {
            "Dir::Etc::sourcelist": self._paths.sources,
            "Dir::Etc::sourceparts": "/dev/null",
            "Dir::State::lists": self._paths.lists,
            "Dir::Cache::archives": self._paths.archives,
            "Dir::Cache::pkgcache": "",
            "Dir::Cache::srcpkgcache": "",
            "APT::Sandbox::User": "root",
            # A robot without a network may not know the time.
            "Acquire::Check-Date": "false",
            "DPkg::Lock::Timeout": f"{LOCK_LIMIT_S:.0f}",
        }
        command = [program, "--quiet", *(f"-o{name}={one}" for name, one in options.items())]
        if program == "apt-get":
            command += ["--yes", "--no-remove", *(f"-oDpkg::Options::={one}" for one in _KEEP)]
        ended = run(*command, *words, limit_s=INSTALL_LIMIT_S, more=_QUIET)
        if ended.status != 0:
            raise UpdateError(f"{else_say or program}: {ended.last_lines}")
        return ended


def _dpkg(*arguments: str) -> Ended:
    locked = {**_QUIET, "DPKG_FRONTEND_LOCKED": "1"}
    return run("dpkg", *_KEEP, *arguments, limit_s=INSTALL_LIMIT_S, more=locked)


def _digest(package: Path) -> str:
    return run("sha256sum", str(package), limit_s=INSTALL_LIMIT_S).output.split(" ")[0]
