"""Progress on a terminal: as lines for a log or a pipe, as a bar for a person."""

from __future__ import annotations

import shutil
from typing import Optional, Protocol, TextIO

from tqdm import tqdm

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import BETWEEN_SENTENCES, Message
from gpr20_common.terminal_text import printable
from gpr20_operator.robot.events import ControlState, Progress
from gpr20_operator.robot.job import remaining

# Without the remaining time as tqdm estimates it: the main control knows it better.
BAR_FORMAT = "{desc}{percentage:3.0f}% |{bar}| {n_fmt}/{total_fmt}{postfix}"


class TerminalBar:
    """One bar at the bottom of the terminal, lines above it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._bar: Optional[tqdm] = None

    def write(self, line: str) -> None:
        """Write a line above the bar."""
        tqdm.write(printable(line), file=self._stream)
        self._stream.flush()

    def show(self, done: int, total: int, before: str, behind: str) -> None:
        """Move the bar, between two texts; the first call makes it."""
        if self._bar is None:
            self._bar = tqdm(total=0, bar_format=BAR_FORMAT, file=self._stream, ncols=_columns())
        self._bar.ncols = _columns()
        self._bar.total = total
        self._bar.n = done
        self._bar.set_description_str(printable(before), refresh=False)
        self._bar.set_postfix_str(printable(behind), refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        """Leave the bar as it is and go to the next line."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def _columns() -> int:
    # Some terminals report no width; tqdm would take that for zero and drop the bar's format.
    return shutil.get_terminal_size().columns


# A line is written for each such part of the survey.
STEP_PERCENT = 10.0


def progress_line(progress: Progress) -> Message:
    """Return one line with everything that `control_survey_data` contains."""
    return Message(
        "{percent:5.1f} %  {visited}/{total} traces  {remaining}",
        percent=progress.completion_percent,
        visited=progress.visited_points,
        total=progress.total_points,
        remaining=remaining(progress),
    )


def terminal_line(message: Message, catalogue: Catalogue) -> str:
    """Return a message as a terminal shows it: the sentence and, in brackets, its details."""
    sentence = catalogue.text(message)
    details = BETWEEN_SENTENCES.join(message.all_details)
    return f"{sentence} ({details})" if details else sentence


class Display(Protocol):
    """Where the operator looks."""

    def note(self, message: Message) -> None:
        """Show a sentence."""

    def show(self, progress: Progress, state: Optional[ControlState]) -> None:
        """Show the progress of the survey, and its state if that is known."""

    def close(self) -> None:
        """Leave the terminal ready for plain lines."""


class PlainDisplay:
    """Writes sentences and a line per ten percent of progress."""

    def __init__(self, stream: TextIO, catalogue: Catalogue) -> None:
        self._stream = stream
        self._catalogue = catalogue
        self._shown: Optional[Progress] = None

    def note(self, message: Message) -> None:
        """Write a sentence."""
        self._stream.write(terminal_line(message, self._catalogue) + "\n")
        # So that the reader of a pipe sees it when it happens.
        self._stream.flush()

    def show(self, progress: Progress, _state: Optional[ControlState]) -> None:
        """Write the progress, if it has changed enough."""
        if self._shown is None or self._is_step(progress, self._shown):
            self._shown = progress
            self.note(progress_line(progress))

    def close(self) -> None:
        """Nothing to do: every line is complete."""

    @staticmethod
    def _is_step(progress: Progress, shown: Progress) -> bool:
        completed = progress.visited_points == progress.total_points != shown.visited_points
        change = abs(progress.completion_percent - shown.completion_percent)
        return completed or change >= STEP_PERCENT


class BarDisplay:
    """Shows the progress as a bar and writes sentences above it."""

    def __init__(self, bar: TerminalBar, catalogue: Catalogue) -> None:
        self._bar = bar
        self._catalogue = catalogue

    def note(self, message: Message) -> None:
        """Write a sentence above the bar."""
        self._bar.write(terminal_line(message, self._catalogue))

    def show(self, progress: Progress, state: Optional[ControlState]) -> None:
        """Move the bar, behind the state of the survey."""
        before = ""
        if state is not None:
            title = self._catalogue.text(state.title)
            simulated = self._catalogue.tr("SIMULATED")
            before = f"{simulated} {title} " if state.simulated else f"{title} "
        done, total = progress.visited_points, progress.total_points
        self._bar.show(done, total, before, self._catalogue.text(remaining(progress)))

    def close(self) -> None:
        """Leave the bar as it is; the lines after it are plain."""
        self._bar.close()
