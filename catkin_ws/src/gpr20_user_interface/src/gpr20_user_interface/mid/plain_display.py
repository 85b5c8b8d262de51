"""Progress as lines, for a log or a pipe."""

from __future__ import annotations

from typing import Optional, TextIO

from gpr20_user_interface.mid.events import ControlState, Progress
from gpr20_user_interface.mid.progress_text import progress_line

STEP_PERCENT = 5.0


class PlainDisplay:
    """Writes one line per change of the status and per five percent of progress."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._state: Optional[ControlState] = None
        self._shown: Optional[Progress] = None

    def note(self, text: str) -> None:
        """Write a sentence of the client."""
        self._stream.write(text + "\n")
        # A reader of a pipe wants to see it when it happens.
        self._stream.flush()

    def status(self, state: ControlState) -> None:
        """Write what main_control does, if that is new."""
        if state != self._state:
            self._state = state
            self.note(f"{state.code.name}: {state.message}")

    def progress(self, progress: Progress) -> None:
        """Write how far the survey is, if that has changed enough."""
        if self._shown is None or self._is_step(progress, self._shown):
            self._shown = progress
            self.note(progress_line(progress))

    def close(self) -> None:
        """Nothing to put right: every line is complete."""

    @staticmethod
    def _is_step(progress: Progress, shown: Progress) -> bool:
        completed = progress.visited_points == progress.total_points != shown.visited_points
        change = abs(progress.completion_percent - shown.completion_percent)
        return completed or change >= STEP_PERCENT
