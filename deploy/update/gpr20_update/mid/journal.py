"""The journal of an update: what it does next, written durably before it does it."""

from __future__ import annotations

import dataclasses
import enum
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Tuple

from gpr20_update.errors import UpdateError
from gpr20_update.low.system import replace_file


class Step(enum.Enum):
    """What is being done; before DONE a power cut returns to the version before."""

    INSTALLING = "installing"
    JUDGING = "judging"
    RETURNING = "returning"
    RESTORING = "restoring"
    DONE = "done"


@dataclass(frozen=True)
class Record:
    """Content of the journal.

    Attributes:
        step: What is being done.
        before: The version that returns if this does not end well.
        after: The version that is being installed, or that the return comes from.
        packages: Names of the packages that were installed before.
        services: The services that ran before.
        backup: File of the configuration as it was before; empty: it stays as it is.
        outcome: How it ended, for people.
    """

    step: Step
    before: str = ""
    after: str = ""
    packages: Tuple[str, ...] = ()
    services: Tuple[str, ...] = ()
    backup: str = ""
    outcome: str = ""

    @property
    def what(self) -> str:
        """What is being done, for people."""
        if self.step is Step.RESTORING:
            return "restoring a backup"
        if self.step is Step.RETURNING:
            return f"returning to version {self.before}"
        return f"installing version {self.after}"


class Journal:
    """A file that holds one record.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def write(self, record: Record) -> None:
        """Replace the record; return when it is durable."""
        fields = {**dataclasses.asdict(record), "step": record.step.value}
        replace_file(self._path, [json.dumps(fields, indent=2).encode()])

    def read(self) -> Optional[Record]:
        """Return the record; None: nothing was ever begun.

        Raises:
            UpdateError: The file is damaged.
        """
        try:
            record = json.loads(self._path.read_text(encoding="utf-8"))
            # Another version of this program, which returned to this one, may have other fields.
            fields = {
                one.name: record[one.name]
                for one in dataclasses.fields(Record)
                if one.name in record
            }
            lists = {name: tuple(record.get(name, ())) for name in ("packages", "services")}
            return Record(**{**fields, **lists, "step": Step(record["step"])})
        except FileNotFoundError:
            return None
        except (ValueError, KeyError, TypeError) as error:
            raise UpdateError(
                f"{self._path} is damaged ({error}); the disk may be failing. Install one version "
                "of the packages with apt-get, then delete the file"
            ) from error

    def unfinished(self) -> Optional[Record]:
        """Return the record of what has not ended; None: there is none."""
        record = self.read()
        return None if record is None or record.step is Step.DONE else record
