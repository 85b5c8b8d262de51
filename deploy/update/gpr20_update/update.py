"""The steps of an update and of a return."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Collection, List, Optional

from gpr20_update import backup
from gpr20_update.packages import Packages
from gpr20_update.robot import Robot
from gpr20_update.system import Paths, UpdateError, replace_file

ALONE = "waiting until no other program installs packages"


@dataclass(frozen=True)
class Record:
    """The journal: what has begun, written durably before it begins.

    Attributes:
        before: The version that returns if this does not end well.
        after: The version that is being installed, or that the return comes from.
        services: The services that ran before.
        backup: Copy of the configuration as it was before; empty: it stays as it is.
        outcome: How it ended, for people; empty: it has not. A power cut then returns.
    """

    before: str = ""
    after: str = ""
    services: List[str] = field(default_factory=list)
    backup: str = ""
    outcome: str = ""


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

    def update(self, stick: Path, no_survey: bool) -> bool:
        """Install the version on a stick; return whether it stays.

        Raises:
            UpdateError: It was refused; nothing has changed.
        """
        self._refuse_to_begin(no_survey)
        before, after = self._packages.installed(), self._packages.offered(stick.resolve())
        self._say(f"{stick}: version {after}, with a good signature")
        if self._packages.is_newer(before, after):
            raise UpdateError(
                f"the stick has version {after}, which is older than {before}, which is "
                "installed; the version before returns with gpr20-update --back"
            )
        if after != before:
            self._packages.check_kept(before)
        self._say("copying and comparing; the stick is needed until the next line")
        self._packages.fetch(after)
        if after == before:
            self._say(f"version {before} is installed; its package is kept, to return to it")
            return True
        self._say("asking the doctor")
        faults = self._robot.faults()
        if faults is None:
            self._say("the doctor cannot judge now; after the update every FAULT counts as new")
        kept = self._keep_configuration(before)
        # Minutes have passed.
        self._robot.refuse_during_survey(no_survey)
        return self._install(Record(before, after, self._robot.active(), str(kept)), faults or ())

    def _install(self, record: Record, known: Collection[str]) -> bool:
        self._say(ALONE)
        with self._packages.alone():
            self._write(record)
        self._say(f"installing version {record.after}; do not switch off")
        try:
            self._robot.stop()
            self._packages.install(record.after)
            self._robot.start(record.services)
            self._say("asking the doctor")
            wrong = self._robot.new_faults(known)
        except (UpdateError, OSError) as error:
            wrong = [str(error)]
        if wrong:
            self._return(record, "; ".join(wrong))
            return False
        ended = f"version {record.after} is installed; the version before was {record.before}"
        self._end(record, ended)
        if not record.services:
            self._say("no service of the robot ran, so the doctor judged this computer alone")
        self._packages.forget(record.before, record.after)
        return True

    def back(self, no_survey: bool) -> None:
        """Return to the version before.

        Raises:
            UpdateError: It was refused, or it failed.
        """
        self._refuse_to_begin(no_survey)
        now, newer = self._packages.installed(), self._packages.is_newer
        older = [one for one in self._packages.kept() if newer(now, one)]
        if not older:
            raise UpdateError(
                f"no package of a version before {now}, which is installed, is kept in "
                f"{self._paths.kept}; install the version that you want with apt-get"
            )
        chosen = next(one for one in older if not any(newer(other, one) for other in older))
        self._packages.check_kept(chosen)
        self._keep_configuration(now)
        self._return(Record(chosen, now, self._robot.active()), "")
        self._say("check that the configuration fits: gpr20-run config check")

    def resume(self, no_survey: bool) -> None:
        """Return to the version before after a power cut or a kill in the middle.

        Raises:
            UpdateError: It failed, and can be repeated.
        """
        record = self._read()
        if record is None or record.outcome:
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
                self._write(record)
                self._robot.stop()
                # At once: whatever the rest meets, a whole release and its configuration are used.
                self._packages.use_slot(record.before)
                if record.backup:
                    backup.apply(Path(record.backup), self._paths)
                self._packages.put_back(record.before)
            finally:
                self._robot.start(record.services)
        ended = f"version {record.before} is installed again"
        self._end(record, f"{ended}; {record.after} did not stay: {why}" if why else ended)

    def status(self) -> None:
        """Say what is used, what is kept and how the last update ended."""
        self._say(f"version in use: {self._packages.slot_version()}")
        self._say(f"versions that are kept: {', '.join(self._packages.kept()) or 'none'}")
        record = self._read()
        if record is None or record.outcome:
            self._say(f"last update or return: {record.outcome if record else 'none'}")
        else:
            self._say(
                f"UNFINISHED: from version {record.before} to {record.after}; return with "
                "gpr20-update --continue"
            )

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
                "package with apt-get, then delete the file"
            ) from error
        # Another version of this program, which returned to this one, may have other fields.
        known = {one.name for one in dataclasses.fields(Record)}
        return Record(**{name: one for name, one in record.items() if name in known})

    def _write(self, record: Record) -> None:
        replace_file(self._paths.journal, json.dumps(dataclasses.asdict(record)).encode())

    def _end(self, record: Record, outcome: str) -> None:
        self._write(dataclasses.replace(record, outcome=outcome))
        self._say(outcome)

    def _refuse_to_begin(self, no_survey: bool) -> None:
        record = self._read()
        if record is not None and not record.outcome:
            raise UpdateError(
                f"an update from version {record.before} to {record.after}, or the return, was "
                "interrupted; between surveys end it with gpr20-update --continue, or restart "
                "this computer"
            )
        self._robot.refuse_during_survey(no_survey)

    def _keep_configuration(self, version: str) -> Path:
        path = backup.keep(self._paths, version)
        self._say(f"the configuration of before is kept in {path}")
        return path
