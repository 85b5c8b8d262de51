"""The search for candidates in a stored survey, by the command `gpr20 candidates`."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Callable, List, Optional, Protocol, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_user_interface.low.analysis_program import ProgramEnded
from gpr20_user_interface.mid.candidate_list import ShownCandidates, candidates_from
from gpr20_user_interface.mid.past_surveys import PastSurvey

LOWEST_PERMITTIVITY, HIGHEST_PERMITTIVITY = 1.0, 100.0
COMPLETE, NOT_COMPLETE = 0, 1
"""Exit statuses with a list."""
NOT_HERE = Message(
    "The data of the survey are not on this computer. Run gpr20 candidates on the computer that "
    "has them."
)
NOT_INSTALLED = Message(
    "The analysis is not installed on this computer. Copy the survey to a computer that has it, "
    "and run gpr20 candidates there."
)
SURVEY_RUNS = Message("A survey is running. Search for candidates when it has ended.")
CANCELLED = Message("The search was cancelled.")
PERMITTIVITY_RANGE = Message(
    "{lowest:g} to {highest:g}; empty: estimate it from the survey",
    lowest=LOWEST_PERMITTIVITY,
    highest=HIGHEST_PERMITTIVITY,
)


class BackgroundProgram(Protocol):
    """Runs one program at a time beside the window, at low priority."""

    def is_installed(self) -> bool:
        """Whether the program is on this computer."""

    def start(self, arguments: Sequence[str]) -> int:
        """Start it and return its number; ProgramEnded comes as an event."""

    def cancel(self) -> None:
        """End it, if it is running."""


class SearchState(enum.Enum):
    """What the search does."""

    READY = "ready"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


class CandidateSearch:
    """One search at a time, never during a survey. Belongs to one thread.

    Args:
        program: Runs the command.
        now_s: A clock that never goes back [s].

    Attributes:
        survey: The survey in question; None before the first.
        state: What the search does.
        found: The list; None unless the search is done.
        problem: Why there is no list; None if that is not known or there is one.
        remarks: What the command said about the survey, in the language of the window.
    """

    def __init__(self, program: BackgroundProgram, now_s: Callable[[], float]) -> None:
        self._program = program
        self._now_s = now_s
        self._data: Optional[Path] = None
        self._number = -1
        self._started_s = 0.0
        self._survey_runs = False
        self.survey: Optional[PastSurvey] = None
        self.state = SearchState.READY
        self.found: Optional[ShownCandidates] = None
        self.problem: Optional[Message] = None
        self.remarks = ""

    @property
    def running_s(self) -> float:
        """How long the search has been running [s]; 0 if it is not."""
        return self._now_s() - self._started_s if self.state is SearchState.RUNNING else 0.0

    @property
    def can_start(self) -> bool:
        """Whether a search can start now."""
        return (
            self.survey is not None
            and not self._survey_runs
            and self.state is not SearchState.RUNNING
        )

    def choose(self, survey: PastSurvey, data: str) -> None:
        """Choose a survey and forget what was found in another.

        Args:
            survey: The survey.
            data: Folder of the surveys on the computer of the storage; empty if it is not known.
        """
        if self.survey is not None and survey.folder == self.survey.folder:
            return
        self.close()
        self.survey, self._data = survey, Path(data) if data else None
        self._rest(SearchState.READY, SURVEY_RUNS if self._survey_runs else None)

    def set_survey_runs(self, runs: bool) -> None:
        """Note whether a survey is running; a search ends when one begins."""
        if runs and not self._survey_runs:
            if self.state is SearchState.RUNNING:
                self._program.cancel()
            if self.state is not SearchState.DONE:
                self._rest(SearchState.READY, SURVEY_RUNS)
        elif not runs and self._survey_runs and self.problem is SURVEY_RUNS:
            self._rest(SearchState.READY, None)
        self._survey_runs = runs

    def start(self, permittivity: str, language: str) -> None:
        """Start the search.

        Args:
            permittivity: As it was entered; empty: estimate it.
            language: Code of the language of the command's sentences.
        """
        if not self.can_start or self.survey is None:
            return
        folder = None if self._data is None else self._data / self.survey.folder
        if folder is None or not (folder / "survey.json").is_file():
            self._rest(SearchState.FAILED, NOT_HERE)
        elif not self._program.is_installed():
            self._rest(SearchState.FAILED, NOT_INSTALLED)
        else:
            options: List[str] = ["--json", "--leave-out-missing", "--language", language]
            if permittivity.strip():
                options.append(f"--permittivity={permittivity.strip().replace(',', '.')}")
            self._number = self._program.start(["candidates", str(folder), *options])
            self._started_s = self._now_s()
            self._rest(SearchState.RUNNING, None)

    def cancel(self) -> None:
        """End a search that is running."""
        if self.state is SearchState.RUNNING:
            self._program.cancel()
            self._rest(SearchState.READY, CANCELLED)

    def close(self) -> None:
        """End whatever is running, and say nothing about it."""
        if self.state is SearchState.RUNNING:
            self._program.cancel()
            self._rest(SearchState.READY, None)

    def on_event(self, event: object) -> None:
        """Take the end of the program; other events are ignored."""
        if not isinstance(event, ProgramEnded) or self.survey is None:
            return
        if self.state is not SearchState.RUNNING or event.number != self._number:
            return  # it was cancelled
        if event.status not in (COMPLETE, NOT_COMPLETE):
            reason = event.errors.strip() or event.output.strip()
            self._rest(SearchState.FAILED, verbatim(reason or f"gpr20: {event.status}"))
            return
        try:
            found = candidates_from(event.output, self.survey.survey_id)
        except InvalidValueError as error:
            self._rest(SearchState.FAILED, error.message)
            return
        self._rest(SearchState.DONE, None)
        self.found, self.remarks = found, " ".join(event.errors.split())

    def _rest(self, state: SearchState, problem: Optional[Message]) -> None:
        self.state, self.problem = state, problem
        self.found, self.remarks = None, ""


def check_permittivity(text: str) -> Optional[Message]:
    """Return what is allowed if a permittivity that was entered is wrong."""
    try:
        value = float(text.strip().replace(",", ".") or LOWEST_PERMITTIVITY)
    except ValueError:
        return PERMITTIVITY_RANGE
    # Written so that NaN is refused too.
    right = LOWEST_PERMITTIVITY <= value <= HIGHEST_PERMITTIVITY
    return None if right else PERMITTIVITY_RANGE
