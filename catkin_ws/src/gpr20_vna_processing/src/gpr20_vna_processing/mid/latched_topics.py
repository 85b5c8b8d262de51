"""The last message of each latched topic, with which a recording begins."""

from __future__ import annotations

import dataclasses
import threading
from typing import Dict, List

from gpr20_survey.recording.recording import RecordedMessage

# Limit of one message that is stored for later recordings; a status has a thousandth of it.
LARGEST_BYTES = 1 << 20


class LatchedTopics:
    """Knows whether messages are recorded now, and what came before on latched topics.

    Its methods may be called from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()  # guards the two below
        self._recording = False
        self._latched: Dict[str, RecordedMessage] = {}

    def note(self, message: RecordedMessage) -> bool:
        """Note a message, unless it is far too large; return whether it is to be recorded."""
        with self._lock:
            if message.latching and message.size_bytes <= LARGEST_BYTES:
                self._latched[message.topic] = message
            return self._recording

    def begin(self, time_ns: int) -> List[RecordedMessage]:
        """Begin to record; return what a recording that begins now must hold.

        Args:
            time_ns: The present moment [ns since 1970, UTC].
        """
        with self._lock:
            self._recording = True
            return [
                dataclasses.replace(message, time_ns=time_ns) for message in self._latched.values()
            ]

    def end(self) -> None:
        """Stop recording."""
        with self._lock:
            self._recording = False
