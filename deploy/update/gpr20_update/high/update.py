"""The steps of an update and of a return."""

from __future__ import annotations

import dataclasses
import json
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Collection, List, Optional

from gpr20_update.low.system import Paths, UpdateError, remove, replace_file
from gpr20_update.mid import backup
from gpr20_update.mid.bundle import SOFTWARE, Bundle, find_bundle, open_bundle
from gpr20_update.mid.packages import Packages
from gpr20_update.mid.robot import Robot

FORMER = "the version before"
ALONE = "waiting until no other program installs packages"
# Values of Record.step. Before DONE, a power cut returns to the version before.
INSTALLING, RETURNING, DONE = "installing", "returning", "done"


@dataclass(frozen=True)
class Record:
    """The journal: what is done next, written durably before it is done.

    Attributes:
        step: What is being done.
        before: The version that returns if this does not end well.
        after: The version that is being installed, or that the return comes from.
        packages: Names of the packages that were installed before.
        services: The services that ran before.
        backup: Copy of the configuration as it was before; empty: it stays as it is.
        outcome: How it ended, for people.
    """

    step: str
    before: str = ""
    after: str = ""
    packages: List[str] = field(default_factory=list)
    services: List[str] = field(default_factory=list)
    backup: str = ""
    outcome: str = ""

    @property
    def what(self) -> str:
        """What is being done, for people."""
        if self.step == RETURNING:
            return f"returning to version {self.before}"
        return f"installing version {self.after}"


class Updater:
    """Does what the command asks for.

    Args:
        paths: Of this computer.
        say: Prints a sentence.
    """

    def __init__(self, paths: Paths, say: Callable[[str], None]) -> None:
        self._paths = paths
        self._packages = Packages(paths)
        self._robot = Robot(paths)
        self._say = say

    def update(self, place: Path, no_survey: bool) -> bool:
        """Install the bundle on a stick; return whether it stays.

        Raises:
            UpdateError: It was refused; nothing has changed.
        """
        self._refuse_to_begin(no_survey)
        stick = open_bundle(find_bundle(place.resolve()), self._paths.signers)
        self._say(f"{stick.folder}: version {stick.version}, signed by {stick.signer}")
        installed = self._packages.installed()
        before = installed[SOFTWARE]
        if self._packages.is_newer(before, stick.version):
            raise UpdateError(
                f"the bundle has version {stick.version}, which is older than {before}, which is "
                f"installed; {FORMER} returns with gpr20-update --back"
            )
        if stick.version != before:
            self._former(before)
        self._say("copying and comparing; the stick is needed until the next line")
        stick.copy(self._paths.kept / stick.version)
        if stick.version == before:
            self._say(f"version {before} is installed; its packages are kept, to return to it")
            return True
        bundle, names = self._kept(stick.version), sorted(installed)
        self._packages.try_install(bundle, names)
        self._say("asking the doctor")
        faults = self._robot.faults()
        if faults is None:
            self._say("the doctor cannot judge now; after the update every FAULT counts as new")
        kept = self._prepare(before)
        # Minutes have passed.
        self._robot.refuse_during_survey(no_survey)
        services = self._robot.active()
        record = Record(INSTALLING, before, bundle.version, names, services, str(kept))
        return self._install(record, bundle, faults or ())

    def _install(self, record: Record, bundle: Bundle, known: Collection[str]) -> bool:
        self._say(ALONE)
        with self._packages.alone():
            self._write(record)
        self._say(f"installing version {record.after}; do not switch off")
        try:
            self._robot.stop()
            self._packages.install(bundle, record.packages)
            self._robot.start(record.services)
            self._say("asking the doctor")
            wrong = self._robot.new_faults(known)
        except (UpdateError, OSError) as error:
            wrong = [str(error)]
        if wrong:
            self._return(record, "; ".join(wrong))
            return False
        self._end(record, f"version {record.after} is installed; {FORMER} was {record.before}")
        if not record.services:
            self._say("no service of the robot ran, so the doctor judged this computer alone")
        self._prune(record)
        return True

    def back(self, no_survey: bool) -> None:
        """Return to the version before.

        Raises:
            UpdateError: It was refused, or it failed.
        """
        self._refuse_to_begin(no_survey)
        installed = self._packages.installed()
        now, newer = installed[SOFTWARE], self._packages.is_newer
        older = [one for one in self._versions() if newer(now, one)]
        if not older:
            raise UpdateError(
                f"no packages of a version before {now}, which is installed, are kept in "
                f"{self._paths.kept}; install the version that you want with apt-get"
            )
        chosen = next(one for one in older if not any(newer(other, one) for other in older))
        self._former(chosen)
        self._prepare(now)
        services = self._robot.active()
        self._return(Record(RETURNING, chosen, now, sorted(installed), services), "")
        self._say("check that the configuration fits: gpr20-run config check")

    def resume(self, no_survey: bool) -> None:
        """Return to the version before after a power cut or a kill in the middle.

        Raises:
            UpdateError: It failed, and can be repeated.
        """
        record = self._read()
        if record is None or record.step == DONE:
            self._say("nothing was interrupted")
            return
        self._robot.refuse_during_survey(no_survey)
        self._return(record, "it was interrupted")

    def _return(self, record: Record, why: str) -> None:
        """Make everything as it was before; may be repeated at any point."""
        self._say(f"returning to version {record.before}" + (f": {why}" if why else ""))
        self._say(ALONE)
        with self._packages.alone():
            try:
                self._write(dataclasses.replace(record, step=RETURNING, outcome=why))
                self._robot.stop()
                # At once: whatever the rest meets, a whole release and its configuration are used.
                self._packages.use_slot(record.before)
                if record.backup:
                    backup.apply(Path(record.backup), self._paths)
                begun = sorted((self._paths.kept / record.after).glob("*.deb"))
                self._packages.put_back(self._kept(record.before), record.packages, begun)
            finally:
                self._robot.start(record.services)
        ended = f"version {record.before} is installed again"
        self._end(record, f"{ended}; {record.after} did not stay: {why}" if why else ended)

    def status(self) -> None:
        """Say what is used, what is kept and how the last update ended."""
        self._say(f"version in use: {self._packages.slot_version()}")
        self._say(f"versions whose packages are kept: {', '.join(self._versions()) or 'none'}")
        record = self._read()
        if record is None or record.step == DONE:
            self._say(f"last update or return: {record.outcome if record else 'none'}")
        else:
            self._say(f"UNFINISHED: {record.what}; finish it with gpr20-update --continue")

    def _read(self) -> Optional[Record]:
        """Return the journal; None: nothing was ever begun."""
        path = self._paths.journal
        if not path.exists():
            return None
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise UpdateError(
                f"{path} is damaged ({error}); the disk may be failing. Install one version of the "
                "packages with apt-get, then delete the file"
            ) from error
        # Another version of this program, which returned to this one, may have other fields.
        known = {one.name for one in dataclasses.fields(Record)}
        return Record(**{name: one for name, one in record.items() if name in known})

    def _write(self, record: Record) -> None:
        replace_file(self._paths.journal, json.dumps(dataclasses.asdict(record)).encode())

    def _end(self, record: Record, outcome: str) -> None:
        self._write(dataclasses.replace(record, step=DONE, outcome=outcome))
        self._say(outcome)

    def _refuse_to_begin(self, no_survey: bool) -> None:
        record = self._read()
        if record is not None and record.step != DONE:
            raise UpdateError(
                f"{record.what} was interrupted; between surveys finish it with gpr20-update "
                "--continue, or restart this computer"
            )
        self._robot.refuse_during_survey(no_survey)

    def _versions(self) -> List[str]:
        return sorted(one.name for one in self._paths.kept.glob("*"))

    def _kept(self, version: str) -> Bundle:
        return open_bundle(self._paths.kept / version, self._paths.signers)

    def _former(self, version: str) -> None:
        """Refuse to begin anything from which no way leads back."""
        if not (self._paths.kept / version).is_dir():
            raise UpdateError(
                f"the packages of version {version}, which is installed, are not kept, so there "
                "would be no way back; run gpr20-update with the bundle of that version first, "
                "which keeps them and installs nothing"
            )
        self._kept(version).check_files()

    def _prepare(self, version: str) -> Path:
        """Keep the configuration, and this program, which is one file: the update replaces it."""
        path = backup.keep(self._paths, version)
        self._say(f"the configuration of before is kept in {path}")
        replace_file(self._paths.program, Path(sys.argv[0]).read_bytes(), 0o700)
        return path

    def _prune(self, record: Record) -> None:
        """Delete packages that no return needs: other versions, and what stays installed."""
        for folder in self._paths.kept.glob("*"):
            if folder.name not in (record.before, record.after):
                remove(folder)
        for file in self._paths.kept.glob("*/*.deb"):
            if not file.name.startswith("gpr20-"):
                file.unlink()
