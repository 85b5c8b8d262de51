"""Who pressed what, in the logs of the surveys."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.calls import Call
from gpr20_web.low.outbox import Outbox

RETRY_S = 5.0
# About an hour; then it is given up.
NOTE_TRIES = 20
# Of a text in an entry; a browser may send more.
MOST_CHARACTERS = 200


class Audit:
    """Takes entries without waiting, from any thread; another one sends them to the storage.

    Args:
        note: Adds values to the log of a survey, by its id, and waits until they are stored.
            OSError: it is called again later; Gpr20Error: the entry is given up.
        report: Takes what did not succeed, in the other thread.
        clock: Gives the time of day.
        retry_s: Before the second try [s].
    """

    def __init__(
        self,
        note: Callable[[str, Mapping[str, Any]], None],
        report: Callable[[Message], None],
        clock: Clock,
        retry_s: float = RETRY_S,
    ) -> None:
        self._clock = clock
        self._notes: Outbox[Tuple[str, Mapping[str, Any]]] = Outbox(
            lambda pair: note(*pair),
            Message("a command was not noted in the log of its survey"),
            report,
            retry_s,
            NOTE_TRIES,
        )

    def add(self, call: Call, what: str, outcome: str, survey: str) -> None:
        """Note what a person did to a survey, by its id; without one there is no log to note it.

        Args:
            call: The request, with its person.
            what: The command.
            outcome: What became of it.
            survey: The id.
        """
        if not survey:
            return
        entry = {
            "time": iso_text(self._clock.time_of_day_us()),
            "user": call.who.name,
            "role": call.who.role.word,
            "address": call.address,
            "command": what,
            "outcome": outcome[:MOST_CHARACTERS],
        }
        self._notes.put((survey, entry))

    @property
    def problem(self) -> Optional[Message]:
        """What does not succeed now, for the diagnostics."""
        return self._notes.problem

    def close(self, limit_s: float) -> None:
        """Send what waits, in at most so long [s]."""
        self._notes.close(limit_s)
