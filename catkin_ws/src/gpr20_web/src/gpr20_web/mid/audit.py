"""Who did what on the page: kept in a file, and in the logs of the surveys."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.files import durable_files
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.calls import Call
from gpr20_web.low.outbox import Outbox
from gpr20_web.roles import Role

Entry = Mapping[str, Any]
RETRY_S = 5.0
# In the log of a survey, about an hour; then it stays in the file alone.
NOTE_TRIES = 20
MOST_BYTES = 5_000_000
# Of a text in an entry; a browser may send more.
MOST_CHARACTERS = 200


class Audit:
    """Takes entries without waiting, from any thread; two threads write them.

    Args:
        path: The file, one JSON object a line. Its predecessor has another ending.
        note: Adds values to the log of a survey, by its id, and waits until they are stored.
            OSError: it is called again later; Gpr20Error: the entry stays in the file alone.
        report: Takes what did not succeed, in one of the threads.
        clock: Gives the time of day.
        retry_s: Before the second try [s].
        most_bytes: Of the file; the next entry begins another one.
    """

    def __init__(
        self,
        path: Path,
        note: Callable[[str, Mapping[str, Any]], None],
        report: Callable[[Message], None],
        clock: Clock,
        retry_s: float = RETRY_S,
        most_bytes: int = MOST_BYTES,
    ) -> None:
        self._path, self._former = path, path.with_suffix(".1.jsonl")
        self._clock, self._most_bytes = clock, most_bytes
        self._lines: Outbox[Entry] = Outbox(
            self._write, Message("the audit was not written"), report, retry_s
        )
        self._notes: Outbox[Tuple[str, Entry]] = Outbox(
            lambda pair: note(*pair),
            Message("a command was not noted in the log of its survey"),
            report,
            retry_s,
            NOTE_TRIES,
        )

    def add(
        self, call: Call, what: str, outcome: str = "", survey: str = "", **values: object
    ) -> None:
        """Add an entry.

        Args:
            call: The request, with its person.
            what: What was asked for: a fixed word.
            outcome: How it ended: a code, or English words.
            survey: Id of the survey whose log has it too.
            values: What the request was about; never a secret.
        """
        person = call.person
        entry: Dict[str, Any] = {
            "time": iso_text(self._clock.time_of_day_us()),
            "user": "" if person is None else person.name,
            "role": Role.NOBODY.word if person is None else person.role.word,
            "address": call.address,
            "command": what,
            "outcome": outcome[:MOST_CHARACTERS],
            "survey": survey[:MOST_CHARACTERS],
            "values": {name: _plain(one) for name, one in values.items()},
        }
        self._lines.put(entry)
        if survey:
            noted = {key: one for key, one in entry.items() if key != "survey"}
            self._notes.put((survey, noted))

    @property
    def problems(self) -> Tuple[Message, ...]:
        """What does not succeed now, for the diagnostics."""
        found = (self._lines.problem, self._notes.problem)
        return tuple(one for one in found if one is not None)

    def close(self, limit_s: float) -> None:
        """Write what waits, in at most about so long [s]."""
        self._lines.close(limit_s)
        self._notes.close(limit_s)

    def _write(self, entry: Entry) -> None:
        durable_files.ensure_folders(self._path.parent, 0o700)
        if self._path.exists() and self._path.stat().st_size > self._most_bytes:
            durable_files.put_in_place(self._path, self._former)
        durable_files.add_line(self._path, entry, 0o600)


def _plain(value: object) -> object:
    """Return a value as JSON has it."""
    if isinstance(value, (bool, int)) or value is None:
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    return str(value)[:MOST_CHARACTERS]
