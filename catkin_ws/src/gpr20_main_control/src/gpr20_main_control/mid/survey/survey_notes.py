"""What happens to a survey beside its traces: notes for its log in the storage."""

from __future__ import annotations

import threading
from collections import deque
from typing import Any, Callable, Deque, Dict, NamedTuple

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import message_record
from gpr20_survey.trace.utc_time import iso_text

# Notes that wait while the storage does not answer; a survey has far fewer.
MAX_WAITING = 1000


class Note(NamedTuple):
    """One note."""

    kind: Kind
    values: Dict[str, Any]


class SurveyNotes:
    """Notes of one survey that the storage does not have yet, in their order."""

    def __init__(self) -> None:
        self._waiting: Deque[Note] = deque(maxlen=MAX_WAITING)
        self._lock = threading.Lock()

    def add(self, kind: Kind, **values: Any) -> None:
        """Add a note with the present time, by which the storage knows a repeated one."""
        with self._lock:
            self._waiting.append(Note(kind, {"time": iso_text(time_of_day_us()), **values}))

    def add_message(self, kind: Kind, message: Message, **values: Any) -> None:
        """Add a note with a sentence: as text, and as template and values."""
        self.add(kind, text=str(message), message=message_record(message), **values)

    def send(self, store: Callable[[Note], None]) -> None:
        """Store the notes that wait; one that could not be stored waits for the next call.

        Args:
            store: Returns when a note is durable.
        """
        while self._waiting:
            note = self._waiting[0]
            store(note)
            with self._lock:
                if self._waiting and self._waiting[0] is note:
                    self._waiting.popleft()
