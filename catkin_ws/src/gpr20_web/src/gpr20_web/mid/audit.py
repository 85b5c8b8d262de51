"""Who did what on the page: kept in a file, and in the logs of the surveys."""

from __future__ import annotations

import json
import math
import threading
from itertools import chain
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.files import durable_files
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.calls import Call, Route
from gpr20_web.errors import AuditFileError, BadRequestError
from gpr20_web.low.outbox import Outbox
from gpr20_web.mid.web_page import WebPage
from gpr20_web.roles import Role

Entry = Mapping[str, Any]
RETRY_S = 5.0
# In the log of a survey, about an hour; then it stays in the file alone.
NOTE_TRIES = 20
MOST_BYTES = 5_000_000
# Of a text in an entry; a browser may send more.
MOST_CHARACTERS = 200
PAGE_ENTRIES = 100


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
        self._last_us, self._numbering = 0, threading.Lock()
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
        person, now_us = call.person, self._clock.time_of_day_us()
        # A number that no other entry has, also when two come at once or the clock was set.
        with self._numbering:
            number = self._last_us = max(self._last_us + 1, now_us)
        entry: Dict[str, Any] = {
            "id": number,
            "time": iso_text(now_us),
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
            noted = {key: one for key, one in entry.items() if key not in ("id", "survey")}
            self._notes.put((survey, noted))

    @property
    def problems(self) -> Tuple[Message, ...]:
        """What does not succeed now, for the diagnostics."""
        found = (self._lines.problem, self._notes.problem)
        return tuple(one for one in found if one is not None)

    def entries(self, before: int, count: int, text: str = "") -> List[Entry]:
        """Return the last entries, the newest first; also those that are not written yet.

        Args:
            before: Id of an entry: only those before it; 0: all.
            count: How many.
            text: Only those that have it, in any letters, in one of their values.

        Raises:
            AuditFileError: The file cannot be read.
        """
        mark = b'"id": %d,' % before
        # Most lines are not decoded: the files have some ten thousand.
        raw = json.dumps(text).lower().strip('"').encode() if text.isascii() else b""
        found: Dict[int, Entry] = {}
        is_older = not before
        # Those that are being written may come twice.
        waiting = [json.dumps(one).encode() for one in reversed(self._lines.waiting)]
        try:
            for line in chain(waiting, durable_files.lines_backwards(self._path, self._former)):
                if not is_older:
                    is_older = mark in line
                elif raw in line.lower():
                    entry = durable_files.object_of(line)
                    if isinstance(entry.get("id"), int) and _has(entry, text.casefold()):
                        found[entry["id"]] = entry
                        if len(found) == count:
                            break
        except OSError as error:
            raise AuditFileError(
                Message("the file of the audit cannot be read: {reason}", reason=os_reason(error))
            ) from error
        return list(found.values())

    def close(self, limit_s: float) -> None:
        """Write what waits, in at most about so long [s]."""
        self._lines.close(limit_s)
        self._notes.close(limit_s)

    def _write(self, entry: Entry) -> None:
        durable_files.ensure_folders(self._path.parent, 0o700)
        if self._path.exists() and self._path.stat().st_size > self._most_bytes:
            durable_files.put_in_place(self._path, self._former)
        durable_files.add_line(self._path, entry, 0o600)


class AuditPage(WebPage):
    """AUDIT: who did what."""

    words: Mapping[str, Message] = {
        "title": Message("Audit"),
        "search": Message("Search"),
        "older": Message("Older"),
        "none": Message("No entries."),
        "time": Message("When"),
        "who": Message("Who"),
        "what": Message("What"),
    }

    def __init__(self, audit: Audit) -> None:
        self._audit = audit
        self.routes = (Route("GET", "/api/audit", Role.ADMIN, self._entries, blocking=True),)

    def _entries(self, call: Call) -> Mapping[str, Any]:
        before, text = call.values.get("before", "0"), call.values.get("text", "")
        if not (before.isascii() and before.isdigit() and len(before) < 17):
            raise BadRequestError(Message("before is the number of an entry"))
        found = self._audit.entries(int(before), PAGE_ENTRIES + 1, text[:MOST_CHARACTERS])
        return {"entries": found[:PAGE_ENTRIES], "more": len(found) > PAGE_ENTRIES}


def _plain(value: object) -> object:
    """Return a value as JSON has it."""
    if isinstance(value, (bool, int)) or value is None:
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    return str(value)[:MOST_CHARACTERS]


def _has(entry: Entry, text: str) -> bool:
    """Return whether one of its values has a text, in any letters."""
    values = entry.get("values")
    more = values.values() if isinstance(values, dict) else ()
    plain = (one for name, one in entry.items() if name != "values")
    return any(text in str(one).casefold() for one in (*plain, *more))
