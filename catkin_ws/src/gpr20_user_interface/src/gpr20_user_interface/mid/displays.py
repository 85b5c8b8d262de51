"""Progress on a terminal: as lines for a log or a pipe, as a bar for somebody who looks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, TextIO

from gpr20_user_interface.low.terminal_bar import TerminalBar
from gpr20_user_interface.mid.events import ControlState, Progress

# A line is written for each such part of the survey.
STEP_PERCENT = 5.0


@dataclass(frozen=True)
class TimeParts:
    """A time in whole days, hours, minutes and seconds."""

    days: int
    hours: int
    minutes: int
    seconds: int


def time_parts(time_s: float) -> TimeParts:
    """Split a time [s], rounded up: nothing that remains is shown as zero."""
    minutes, seconds = divmod(max(0, math.ceil(time_s)), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    return TimeParts(days, hours, minutes, seconds)


def time_text(time_s: float) -> str:
    """Return a time [s] as `0d:0h:18m:48s`."""
    parts = time_parts(time_s)
    return f"{parts.days}d:{parts.hours}h:{parts.minutes}m:{parts.seconds}s"


def remaining_text(progress: Progress) -> str:
    """Return the remaining time and its basis: the plan, or the points taken so far."""
    basis = "plan" if progress.visited_points == 0 else "measured"
    return f"{time_text(progress.remaining_s)} remaining ({basis})"


def progress_line(progress: Progress) -> str:
    """Return one line with everything that `control_survey_data` says."""
    return (
        f"{progress.completion_percent:5.1f} %  {progress.visited_points}/{progress.total_points} "
        f"traces  {remaining_text(progress)}"
    )


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


class BarDisplay:
    """Shows the progress as a bar and writes changes of the status above it."""

    def __init__(self, bar: TerminalBar) -> None:
        self._bar = bar
        self._state: Optional[ControlState] = None
        self._progress: Optional[Progress] = None

    def note(self, text: str) -> None:
        """Write a sentence of the client above the bar."""
        self._bar.write(text)

    def status(self, state: ControlState) -> None:
        """Write what main_control does above the bar, if that is new."""
        if state == self._state:
            return
        self._state = state
        self._bar.write(f"{state.code.name}: {state.message}")
        self._refresh()

    def progress(self, progress: Progress) -> None:
        """Move the bar."""
        self._progress = progress
        self._refresh()

    def close(self) -> None:
        """Leave the bar as it is; what follows are plain lines."""
        self._bar.close()

    def _refresh(self) -> None:
        if self._progress is None:
            return
        self._bar.show(
            self._progress.visited_points,
            self._progress.total_points,
            _before(self._state),
            remaining_text(self._progress),
        )


def _before(state: Optional[ControlState]) -> str:
    if state is None:
        return ""
    simulated = "SIMULATED " if state.simulated else ""
    return f"{simulated}{state.code.name} "
