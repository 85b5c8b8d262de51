"""The steps of an update, of a return, of a backup and of a restore."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Callable, Set, Tuple

from gpr20_update.errors import UpdateError
from gpr20_update.low.paths import Paths
from gpr20_update.low.system import remove, replace_file, shown
from gpr20_update.mid import backup
from gpr20_update.mid.bundle import SOFTWARE, Bundle, find_bundle, open_bundle
from gpr20_update.mid.journal import Journal, Record, Step
from gpr20_update.mid.packages import Packages
from gpr20_update.mid.robot import Robot

FORMER = "the version before"


class Updater:
    """Does what the command asks for.

    Args:
        paths: Of this computer.
        packages: Its packages.
        robot: Its robot.
        say: Prints a sentence.
    """

    def __init__(
        self, paths: Paths, packages: Packages, robot: Robot, say: Callable[[str], None]
    ) -> None:
        self._paths = paths
        self._packages = packages
        self._robot = robot
        self._say = say
        self._journal = Journal(paths.journal)

    def update(self, place: Path, no_survey: bool) -> bool:
        """Install the bundle on a stick; return whether it stays.

        Raises:
            UpdateError: It was refused; nothing has changed.
        """
        self._refuse_to_begin(no_survey)
        stick = open_bundle(find_bundle(place.resolve()), self._paths.signers)
        self._say(f"{shown(stick.folder)}: version {stick.version}, signed by {stick.signer}")
        self._packages.check_architecture(stick)
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
        kept = self._keep(before)
        self._keep_program()
        # Minutes have passed.
        self._robot.refuse_during_survey(no_survey)
        record = Record(
            Step.INSTALLING,
            before,
            bundle.version,
            tuple(names),
            tuple(self._robot.active()),
            str(kept),
        )
        return self._install(record, bundle, tuple(faults or ()))

    def _install(self, record: Record, bundle: Bundle, known: Tuple[str, ...]) -> bool:
        with self._packages.alone(self._wait):
            self._journal.write(record)
        self._say(f"installing version {record.after}; do not switch off")
        try:
            self._robot.stop()
            self._packages.install(bundle, list(record.packages))
            self._journal.write(dataclasses.replace(record, step=Step.JUDGING))
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
        self._prune({record.before, record.after})
        return True

    def back(self, no_survey: bool) -> None:
        """Return to the version before.

        Raises:
            UpdateError: It was refused, or it failed.
        """
        self._refuse_to_begin(no_survey)
        installed = self._packages.installed()
        now = installed[SOFTWARE]
        kept = [one.name for one in self._paths.kept.glob("*")]
        older = [one for one in kept if self._packages.is_newer(now, one)]
        if not older:
            raise UpdateError(
                f"no packages of a version before {now}, which is installed, are kept in "
                f"{self._paths.kept}; install the version that you want with apt-get"
            )
        newer = self._packages.is_newer
        chosen = next(one for one in older if not any(newer(other, one) for other in older))
        self._former(chosen)
        self._keep(now)
        self._keep_program()
        services = tuple(self._robot.active())
        record = Record(Step.RETURNING, chosen, now, tuple(sorted(installed)), services)
        self._return(record, "")
        self._say("check that the configuration fits: gpr20-run config check")

    def resume(self, no_survey: bool) -> None:
        """End what a power cut or a kill has interrupted: return, or finish the restore.

        Raises:
            UpdateError: It failed, and can be repeated.
        """
        record = self._journal.unfinished()
        if record is None:
            self._say("nothing was interrupted")
            return
        self._robot.refuse_during_survey(no_survey)
        if record.step is Step.RESTORING:
            self._restore(record)
        else:
            self._return(record, "it was interrupted")

    def _return(self, record: Record, why: str) -> None:
        """Make everything as it was before; may be repeated at any point."""
        self._say(f"returning to version {record.before}" + (f": {shown(why)}" if why else ""))
        with self._packages.alone(self._wait):
            try:
                self._journal.write(dataclasses.replace(record, step=Step.RETURNING, outcome=why))
                self._robot.stop()
                # At once: whatever the rest meets, a whole release and its configuration are used.
                self._packages.use_slot(record.before)
                if record.backup:
                    backup.apply(backup.read(Path(record.backup)), self._paths)
                begun = sorted((self._paths.kept / record.after).glob("*.deb"))
                self._packages.put_back(self._kept(record.before), list(record.packages), begun)
            finally:
                self._robot.start(record.services)
        ended = f"version {record.before} is installed again"
        self._end(record, f"{ended}; {record.after} did not stay: {why}" if why else ended)

    def status(self) -> None:
        """Say what is installed, what is kept and how the last update ended."""
        for name, (state, version) in self._packages.states().items():
            self._say(f"{name} {version}: {state}")
        self._say(f"version in use: {self._packages.slot_version()}")
        kept = ", ".join(sorted(one.name for one in self._paths.kept.glob("*")))
        self._say(f"versions whose packages are kept: {kept or 'none'}")
        record = self._journal.read()
        if record is None:
            self._say("last update, return or restore: none")
        elif record.step is Step.DONE:
            self._say(f"last update, return or restore: {shown(record.outcome)}")
        else:
            self._say(f"UNFINISHED: {record.what}; finish it with gpr20-update --continue")

    def backup(self, path: Path) -> None:
        """Write a backup into a file that must not exist."""
        if path.exists():
            raise UpdateError(f"{shown(path)} exists; name another file")
        taken = backup.take(self._paths, self._packages.slot_version())
        if taken.left_out:
            raise UpdateError(
                f"a backup holds files, and these are none: {shown(', '.join(taken.left_out))}. "
                "Replace a link by the file or folder that it names; move pipes and sockets away"
            )
        backup.write(taken, path.absolute())
        self._say(f"{shown(path)}: {len(taken.files)} files, without private keys")

    def restore(self, path: Path, no_survey: bool) -> None:
        """Make configuration and plans those of a backup.

        Raises:
            UpdateError: It was refused; nothing has changed.
        """
        self._refuse_to_begin(no_survey)
        wanted = backup.read(path)
        self._keep(self._packages.slot_version())
        copy = self._paths.state / "restore.tar.gz"
        backup.write(wanted, copy)
        self._keep_program()
        services = tuple(self._robot.active())
        self._restore(Record(Step.RESTORING, services=services, backup=str(copy)))
        if wanted.people:
            self._say(f"members of the group gpr20 were {shown(', '.join(wanted.people))}")
            self._say("add those who use this computer: adduser NAME gpr20")
        self._say("check that the configuration fits: gpr20-run config check")

    def _restore(self, record: Record) -> None:
        self._journal.write(record)
        self._robot.stop()
        backup.apply(backup.read(Path(record.backup)), self._paths)
        self._robot.start(record.services)
        self._end(record, "a backup was restored")

    def _end(self, record: Record, outcome: str) -> None:
        self._journal.write(dataclasses.replace(record, step=Step.DONE, outcome=outcome))
        self._say(shown(outcome))

    def _refuse_to_begin(self, no_survey: bool) -> None:
        record = self._journal.unfinished()
        if record is not None:
            raise UpdateError(
                f"{record.what} was interrupted; between surveys finish it with gpr20-update "
                "--continue, or restart this computer"
            )
        self._robot.refuse_during_survey(no_survey)

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

    def _wait(self) -> None:
        self._say("waiting: another program installs packages")

    def _keep(self, version: str) -> Path:
        path, taken = backup.keep(self._paths, version)
        self._say(f"the configuration of before is kept in {path}")
        if taken.left_out:
            self._say(f"not kept, and not changed, as no files: {shown(', '.join(taken.left_out))}")
        return path

    def _keep_program(self) -> None:
        """Keep this program, which is one file: the update may replace it."""
        replace_file(self._paths.program, [Path(sys.argv[0]).read_bytes()], 0o700)

    def _prune(self, versions: Set[str]) -> None:
        """Delete packages that no return needs: other versions, and what stays installed."""
        for folder in self._paths.kept.glob("*"):
            if folder.name not in versions:
                remove(folder)
        for file in self._paths.kept.glob("*/*.deb"):
            if not file.name.startswith("gpr20-"):
                file.unlink()
