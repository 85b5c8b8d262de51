"""A terminal: progress as lines for a log or a pipe, as a bar for a person; a question."""

from __future__ import annotations

import select
import shutil
import sys
from typing import Callable, Optional, TextIO

from tqdm import tqdm

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import BETWEEN_SENTENCES, Message
from gpr20_common.terminal_text import printable
from gpr20_operator.robot.events import ControlState, Progress
from gpr20_operator.robot.job import remaining

# A line is written for each such part of the survey.
STEP_PERCENT = 10.0
# Without the remaining time as tqdm estimates it: the main control knows it better.
BAR_FORMAT = "{desc}{percentage:3.0f}% |{bar}| {n_fmt}/{total_fmt}{postfix}"
POLL_S = 0.2
# In English and Spanish.
YES = ("y", "yes", "s", "si", "s\u00ed")


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
    """Return a message as a line of a terminal: the sentence and, in brackets, its details."""
    sentence = catalogue.text(message)
    details = BETWEEN_SENTENCES.join(message.all_details)
    return printable(f"{sentence} ({details})" if details else sentence)


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
        """Show the progress of the survey, and its state if that is known."""
        if self._shown is None or self._is_step(progress, self._shown):
            self._shown = progress
            self.note(progress_line(progress))

    def close(self) -> None:
        """Leave the terminal ready for other lines."""

    @staticmethod
    def _is_step(progress: Progress, shown: Progress) -> bool:
        completed = progress.visited_points == progress.total_points != shown.visited_points
        change = abs(progress.completion_percent - shown.completion_percent)
        return completed or change >= STEP_PERCENT


class BarDisplay(PlainDisplay):
    """Shows the progress as a bar at the bottom, and writes sentences above it."""

    def __init__(self, stream: TextIO, catalogue: Catalogue) -> None:
        super().__init__(stream, catalogue)
        self._bar: Optional[tqdm] = None

    def note(self, message: Message) -> None:
        """Write a sentence above the bar."""
        tqdm.write(terminal_line(message, self._catalogue), file=self._stream)
        self._stream.flush()

    def show(self, progress: Progress, state: Optional[ControlState]) -> None:
        """Move the bar, behind the state of the survey; the first call makes it."""
        before = ""
        if state is not None:
            title = self._catalogue.text(state.title)
            simulated = self._catalogue.tr("SIMULATED")
            before = f"{simulated} {title} " if state.simulated else f"{title} "
        # Some terminals report no width; tqdm would take that for zero and drop the format.
        columns = shutil.get_terminal_size().columns
        if self._bar is None:
            self._bar = tqdm(total=0, bar_format=BAR_FORMAT, file=self._stream, ncols=columns)
        self._bar.ncols = columns
        self._bar.total, self._bar.n = progress.total_points, progress.visited_points
        self._bar.set_description_str(printable(before), refresh=False)
        behind = self._catalogue.text(remaining(progress))
        self._bar.set_postfix_str(printable(behind), refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        """Leave the bar as it is; the lines after it are plain."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def is_confirmed(question: str, cancelled: Callable[[], bool]) -> bool:
    """Ask, and return whether a person answers with yes before it is cancelled."""
    print(f"{printable(question)} ", end="", flush=True)
    while not cancelled():
        ready, _, _ = select.select([sys.stdin], [], [], POLL_S)
        if ready:
            return sys.stdin.readline().strip().lower() in YES
    print(flush=True)
    return False
