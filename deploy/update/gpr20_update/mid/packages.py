"""The installed packages: what is installed, install another version, return to one."""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from pathlib import Path
from typing import Dict, Iterator, List, Tuple

from gpr20_update.low.system import Ended, Paths, UpdateError, is_taken, replace_file, run, sync
from gpr20_update.mid.bundle import SOFTWARE, Bundle

QUERY_LIMIT_S = 60.0
INSTALL_LIMIT_S = 1800.0
LOCK_LIMIT_S = 120.0
_POLL_S = 0.2
INSTALLED = "installed"
# What dpkg calls a package that is not there, or of which only its configuration is.
_ABSENT = frozenset({"not-installed", "config-files"})
# Nobody is asked; a configuration file that somebody changed stays as it is.
_QUIET = {"DEBIAN_FRONTEND": "noninteractive", "NEEDRESTART_SUSPEND": "1"}
_KEEP = ("--force-confdef", "--force-confold")


class Packages:
    """The packages of this computer.

    Args:
        paths: Of this computer.
    """

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def installed(self) -> Dict[str, str]:
        """Return the version of each package of this project, by name.

        Raises:
            UpdateError: None is installed, or one is between two states or versions.
        """
        found = {name: one for name, one in self._all().items() if name.startswith("gpr20-")}
        if SOFTWARE not in found:
            raise UpdateError(f"{SOFTWARE} is not installed; install it first (docs/install.md)")
        if len(set(found.values())) != 1 or found[SOFTWARE][0] != INSTALLED:
            raise UpdateError(
                f"the packages {', '.join(found)} are not all whole and of one version; run "
                "dpkg --configure -a and install one version of all of them first"
            )
        return {name: version for name, (_state, version) in found.items()}

    def is_newer(self, version: str, than: str) -> bool:
        """Return whether a version is newer than another one."""
        asked = ("dpkg", "--compare-versions", version, "gt", than)
        return run(*asked, limit_s=QUERY_LIMIT_S).status == 0

    def try_install(self, bundle: Bundle, names: List[str]) -> None:
        """Find out whether a bundle can be installed; change nothing.

        Raises:
            UpdateError: It cannot.
        """
        missing = [name for name in names if name not in bundle.packages]
        if missing:
            raise UpdateError(
                f"the bundle of version {bundle.version} has no {', '.join(missing)}, which is "
                "installed here; make the bundle with every package"
            )
        (self._paths.state / "lists/partial").mkdir(parents=True, exist_ok=True)
        ended = self._apt(bundle, "update")
        if ended.status == 0:
            ended = self._apt(bundle, "--simulate", "install", *names)
        if ended.status != 0:
            raise UpdateError(
                f"version {bundle.version} cannot be installed on this system: {ended.last_lines}. "
                "Use the bundle for this kind of computer and this version of Debian or Ubuntu"
            )

    def install(self, bundle: Bundle, names: List[str]) -> None:
        """Install packages of a bundle, with what they need of it; without a network.

        Raises:
            UpdateError: It failed in the middle.
        """
        ended = self._apt(bundle, "install", *names)
        if ended.status != 0:
            raise UpdateError(f"the installation failed: {ended.last_lines}")

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

    def put_back(self, bundle: Bundle, names: List[str], other: List[Path]) -> None:
        """Install the former version, whatever state an installation has left; may be repeated.

        Nobody else may install meanwhile, see `alone`.

        Args:
            bundle: The former version.
            names: What of it was installed.
            other: Packages that the interrupted installation may have begun.

        Raises:
            UpdateError: It failed.
        """
        before = self._all()
        added = [one for one in before if one.startswith("gpr20-") and one not in names]
        if added:
            _dpkg("--force-depends", "--remove", *added)
        wanted = (INSTALLED, bundle.version)
        files = bundle.files_of([one for one in names if before.get(one) != wanted])
        # Only what is half done: no package of the distribution returns.
        begun = {one for one, (state, _) in before.items() if state != INSTALLED} - set(names)
        files += [one for one in other if one.name.split("_")[0] in begun]
        ended = _dpkg("--install", *map(str, files)) if files else None
        if ended is None or ended.status != 0:
            ended = _dpkg("--configure", "--pending")
        after = self._all()
        if any(after.get(name) != wanted for name in names):
            raise UpdateError(
                f"version {bundle.version} could not be installed again: {ended.last_lines}"
            )

    def use_slot(self, version: str) -> None:
        """Let services and commands use a release that is in a slot at once, if it is.

        dpkg alone would leave a mix: after 8 of 30 power cuts (docs/evidence/bare_debian.md).
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

    def _all(self) -> Dict[str, Tuple[str, str]]:
        """Return state and version of each package that is there, by name."""
        asked = ("dpkg-query", "-W", "-f", "${Package} ${db:Status-Status} ${Version}\\n")
        ended = run(*asked, limit_s=QUERY_LIMIT_S)
        if ended.status != 0:
            raise UpdateError(f"dpkg does not answer: {ended.last_lines}")
        # One that is not installed has no version.
        lines = [one.split(" ") for one in ended.output.splitlines()]
        return {name: (state, version) for name, state, version in lines if state not in _ABSENT}

    def _apt(self, bundle: Bundle, *words: str) -> Ended:
        """Run apt-get with the bundle as the only source; its sums were compared before."""
        sources = self._paths.state / "sources.list"
        replace_file(sources, f"deb [trusted=yes] file:{bundle.folder} ./\n".encode())
        options = {
            "Dir::Etc::sourcelist": sources,
            "Dir::Etc::sourceparts": "/dev/null",
            "Dir::State::lists": self._paths.state / "lists",
            "Dir::Cache::pkgcache": "",
            "Dir::Cache::srcpkgcache": "",
            "APT::Sandbox::User": "root",
            "APT::Get::Show-User-Simulation-Note": "false",
            "DPkg::Lock::Timeout": f"{LOCK_LIMIT_S:.0f}",
        }
        command = ["apt-get", "--quiet=2", "--yes", "--no-install-recommends", "--no-remove"]
        command += [f"-o{name}={value}" for name, value in options.items()]
        command += [f"-oDpkg::Options::={one}" for one in _KEEP]
        exact = [f"{one}={bundle.version}" if one in bundle.packages else one for one in words]
        return run(*command, *exact, limit_s=INSTALL_LIMIT_S, more=_QUIET)


def _dpkg(*arguments: str) -> Ended:
    locked = {**_QUIET, "DPKG_FRONTEND_LOCKED": "1"}
    return run("dpkg", *_KEEP, *arguments, limit_s=INSTALL_LIMIT_S, more=locked)
