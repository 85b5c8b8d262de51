"""The search for candidates in a stored survey, which the imaging node makes."""

from __future__ import annotations

import enum
from typing import Callable, Optional

from gpr20_common.message import Message
from gpr20_operator.jobs.imaging import (
    CandidatesFound,
    HidingMapped,
    RequestFailed,
    SearchRequests,
    new_request_id,
)
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_survey.results.candidates import CandidateList
from gpr20_survey.results.hidden_target import Targets
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.results.survey_summary import SurveySummary

ESTIMATE = 0.0
"""What is sent for an empty entry."""
PERMITTIVITY_RANGE = Message(
    "{lowest:g} to {highest:g}; empty: not known",
    lowest=MIN_PERMITTIVITY,
    highest=LARGEST_PERMITTIVITY,
)


def check_permittivity(text: str) -> Optional[Message]:
    """Return what is allowed if a permittivity that was entered is wrong."""
    try:
        value = float(text.strip().replace(",", ".") or MIN_PERMITTIVITY)
    except ValueError:
        return PERMITTIVITY_RANGE
    # Written so that NaN is refused too.
    right = MIN_PERMITTIVITY <= value <= LARGEST_PERMITTIVITY
    return None if right else PERMITTIVITY_RANGE


def entered_permittivity(text: str) -> float:
    """Return the value of an entry that was checked."""
    return float(text.strip().replace(",", ".") or ESTIMATE)


# The mine that is searched for most: small, of plastic.
TARGET = Targets.TYPE_72.value.name
SURVEY_RUNS = Message("A survey is running. Search for candidates when it has ended.")
CANCELLED = Message("The search was cancelled.")
OTHER_SURVEY = Message("The list of candidates is that of another survey.")


class SearchState(enum.Enum):
    """What the search does."""

    READY = "ready"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


class CandidateSearch:
    """One search at a time, never during a survey. Belongs to one thread.

    Args:
        requests: The imaging node.
        now_s: A clock that never goes back [s].

    Attributes:
        survey: The survey in question; None before the first.
        state: What the search does.
        found: The list; None unless the search is done.
        hiding: Where a mine could hide; None unless that was asked for.
        problem: Why there is no list; None if that is not known or there is one.
        remarks: What the analysis said about the survey, in the language of the window.
    """

    def __init__(self, requests: SearchRequests, now_s: Callable[[], float]) -> None:
        self._requests = requests
        self._now_s = now_s
        self._request_id = ""
        self._started_s = 0.0
        self._survey_runs = False
        self._permittivity = 0.0
        self.survey: Optional[SurveySummary] = None
        self.state = SearchState.READY
        self.found: Optional[CandidateList] = None
        self.hiding: Optional[HidingMap] = None
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

    def choose(self, survey: SurveySummary) -> None:
        """Choose a survey and forget what was found in another."""
        if self.survey is not None and survey.folder == self.survey.folder:
            return
        self.close()
        self.survey = survey
        self._rest(SearchState.READY, SURVEY_RUNS if self._survey_runs else None)

    def set_survey_runs(self, runs: bool) -> None:
        """Note whether a survey is running; a search ends when one begins."""
        if runs and not self._survey_runs:
            if self.state is SearchState.RUNNING:
                self._requests.cancel(self._request_id)
            if self.state is not SearchState.DONE:
                self._rest(SearchState.READY, SURVEY_RUNS)
        elif not runs and self._survey_runs and self.state is SearchState.READY:
            self._rest(SearchState.READY, None)
        self._survey_runs = runs

    def start(self, permittivity: str, language: str) -> None:
        """Start the search.

        Args:
            permittivity: As it was entered and checked; empty: not known.
            language: Code of the language of the analysis' sentences.
        """
        if not self.can_start or self.survey is None:
            return
        self._request_id = new_request_id()
        self._started_s = self._now_s()
        self._permittivity = entered_permittivity(permittivity)
        self._rest(SearchState.RUNNING, None)
        self._requests.find_candidates(
            self._request_id, self.survey.folder, self._permittivity, language
        )

    def start_hiding(self) -> None:
        """Find where a mine could hide from the search that has found the list."""
        found, survey = self.found, self.survey
        if not self.can_start or found is None or survey is None:
            return
        self._request_id = new_request_id()
        self._started_s = self._now_s()
        self._rest(SearchState.RUNNING, None)
        self.found = found
        # Not that of the list, which is a guess where none was entered.
        self._requests.map_hidden(self._request_id, survey.folder, self._permittivity, TARGET)

    def cancel(self) -> None:
        """End a search that is running."""
        if self.state is SearchState.RUNNING:
            self._requests.cancel(self._request_id)
            self._rest(SearchState.READY, CANCELLED)

    def close(self) -> None:
        """End whatever is running, and say nothing about it."""
        if self.state is SearchState.RUNNING:
            self._requests.cancel(self._request_id)
            self._rest(SearchState.READY, None)

    def on_event(self, event: object) -> None:
        """Take the end of the search; other events are ignored."""
        answers = (CandidatesFound, HidingMapped, RequestFailed)
        if not isinstance(event, answers) or self.survey is None:
            return
        if self.state is not SearchState.RUNNING or event.request_id != self._request_id:
            return  # it was cancelled
        if isinstance(event, RequestFailed):
            self._rest(SearchState.FAILED, event.reason)
            return
        if event.found.survey_id != self.survey.survey_id:
            self._rest(SearchState.FAILED, OTHER_SURVEY)
            return
        if isinstance(event, HidingMapped):
            self.state, self.hiding = SearchState.DONE, event.found
            return
        self._rest(SearchState.DONE, None)
        self.found, self.remarks = event.found, " ".join(event.remarks.split())

    def _rest(self, state: SearchState, problem: Optional[Message]) -> None:
        self.state, self.problem = state, problem
        self.found, self.hiding, self.remarks = None, None, ""
