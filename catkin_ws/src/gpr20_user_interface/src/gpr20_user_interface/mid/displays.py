"""Progress on a terminal: as lines for a log or a pipe, as a bar for somebody who looks."""

from __future__ import annotations

import math
from typing import Optional, Protocol, TextIO, Tuple

from gpr20_user_interface.low.terminal_bar import TerminalBar
from gpr20_user_interface.mid.events import ControlState, Progress

# A line is written for each such part of the survey.
STEP_PERCENT = 5.0


def time_parts(time_s: float) -> Tuple[int, int, int, int]:
    """Split a time [s] into whole days, hours, minutes and seconds.

    It is rounded up: nothing that remains is shown as zero.
    """
    minutes, seconds = divmod(max(0, math.ceil(time_s)), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    return days, hours, minutes, seconds


def time_text(time_s: float) -> str:
    """Return a time [s] as `0d:0h:18m:48s`."""
    return ":".join(f"{number}{unit}" for number, unit in zip(time_parts(time_s), "dhms"))


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


class Display(Protocol):
    """Where the operator looks."""

    def note(self, text: str) -> None:
        """Show a sentence."""

    def show(self, progress: Progress, state: Optional[ControlState]) -> None:
        """Show how far the survey is, and what main_control does if that is known."""

    def close(self) -> None:
        """Leave the terminal ready for plain lines."""


class PlainDisplay:
    """Writes sentences and a line per five percent of progress."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._shown: Optional[Progress] = None

    def note(self, text: str) -> None:
        """Write a sentence."""
        self._stream.write(text + "\n")
        # A reader of a pipe wants to see it when it happens.
        self._stream.flush()

    def show(self, progress: Progress, _state: Optional[ControlState]) -> None:
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
    """Shows the progress as a bar and writes sentences above it."""

    def __init__(self, bar: TerminalBar) -> None:
        self._bar = bar

    def note(self, text: str) -> None:
        """Write a sentence above the bar."""
        self._bar.write(text)

    def show(self, progress: Progress, state: Optional[ControlState]) -> None:
        """Move the bar, behind the state of the survey."""
        before = ""
        if state is not None:
            before = ("SIMULATED " if state.simulated else "") + f"{state.code.name} "
        done, total = progress.visited_points, progress.total_points
        self._bar.show(done, total, before, remaining_text(progress))

    def close(self) -> None:
        """Leave the bar as it is; what follows are plain lines."""
        self._bar.close()
