"""Publishing each trace once when it is stored, and each record of the log."""

from __future__ import annotations

from typing import Callable, Dict, Mapping, Optional, Tuple

from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace.trace import Trace


class Publication:
    """Publishes each trace once in the life of this process. Belongs to the storage thread.

    A trace can be found stored when its survey is reopened although it was never published: the
    disk, or this process, failed between the first of its files and the last.

    Attributes:
        logged: Publishes the message of a record of the log.
    """

    def __init__(
        self,
        on_stored: Callable[[RecordedMessage], None],
        on_logged: Callable[[RecordedMessage], None],
    ) -> None:
        self._on_stored = on_stored
        self.logged = on_logged
        # By survey and index: traces that have a durable file, but were not published.
        self._waiting: Dict[Tuple[str, int], Trace] = {}
        # By survey: the largest index that was published. Not its time: clocks are set back.
        self._newest: Dict[str, int] = {}

    def expect(self, trace: Trace) -> None:
        """Note a trace that has a durable file and will be published when it is stored."""
        self._waiting[trace.survey_id, trace.index] = trace

    def stored(self, trace: Trace, message: RecordedMessage) -> None:
        """Publish a trace that is stored now, by its message."""
        self._waiting.pop((trace.survey_id, trace.index), None)
        self._on_stored(message)
        newest = self._newest.get(trace.survey_id, -1)
        self._newest[trace.survey_id] = max(newest, trace.index)

    def reopened(
        self,
        survey_id: str,
        stored: Mapping[int, TraceFile],
        last: Optional[Trace],
        message_of: Callable[[Trace], RecordedMessage],
    ) -> None:
        """Publish the traces of a survey that are stored, but may not have been published.

        These are the ones that this process expected, and the last one, after which another
        process may have died. Subscribers recognize a repeated trace by its `sample_id`.

        Args:
            survey_id: UUID of the survey that was reopened.
            stored: The traces that are stored, by their index.
            last: The trace that was stored last; None if there is none.
            message_of: Makes the message of a trace.
        """
        for key in sorted(key for key in self._waiting if key[0] == survey_id):
            trace = self._waiting.pop(key)
            file = stored.get(trace.index)
            if file is not None and file.fingerprint == trace.fingerprint():
                self.stored(trace, message_of(trace))
        if last is not None and last.index > self._newest.get(survey_id, -1):
            self.stored(last, message_of(last))
