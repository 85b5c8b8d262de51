"""The list of past surveys: how each ended and what can be done with it."""

from __future__ import annotations

import enum
from typing import List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.plan.imported import IMPORTED
from gpr20_survey.results.survey_summary import SurveySummary

NO_LIST = Message("During a replay no list of surveys is available.")


class Verdict(enum.Enum):
    """How a survey ended, in one word."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    RUNNING = "running"
    UNREADABLE = "unreadable"
    IMPORTED = "imported"
    """It has no plan: nothing says whether it is complete."""


class PastSurveys:
    """Collects the pages of the list; knows which survey is running.

    Attributes:
        revision: Changes with everything that a view shows of this.
        outdated: Whether the list should be requested again when it is visible.
        problem: Why the list or a survey cannot be read; None if it can.
        more: Whether there are older ones.
        replay: Whether a replay is shown, and no robot.
    """

    def __init__(self) -> None:
        self.revision = 0
        self.outdated = False
        self.problem: Optional[Message] = None
        self._surveys: List[SurveySummary] = []
        self.more = False
        self._running_id = ""
        self.replay = False

    @property
    def surveys(self) -> Tuple[SurveySummary, ...]:
        """The surveys of the pages so far, the newest first."""
        return tuple(self._surveys)

    @property
    def next_before(self) -> str:
        """Folder before which the next page begins; empty: the first page."""
        return self._surveys[-1].folder if self._surveys else ""

    def find(self, folder: str) -> Optional[SurveySummary]:
        """Return a survey of the pages so far; None if it is not among them."""
        return next((one for one in self._surveys if one.folder == folder), None)

    def take(self, before: str, surveys: Tuple[SurveySummary, ...], more: bool) -> None:
        """Add a page; the first one replaces the list."""
        self._change(problem=None)
        if not before:
            self._surveys = []
        elif before != self.next_before:
            return  # the list was replaced meanwhile
        self._surveys.extend(surveys)
        self.more = more

    def set_running(self, survey_id: str) -> None:
        """Note which survey is running; empty: none."""
        if survey_id != self._running_id:
            self._running_id = survey_id
            self.set_outdated()

    def set_replay(self, replay: bool) -> None:
        """Note whether a replay is shown, beside which nothing can be resumed."""
        self.replay = replay
        self.outdated = not replay
        self._change(problem=NO_LIST if replay else None)

    def set_outdated(self) -> None:
        """Note that the surveys have changed."""
        if not self.replay:
            self.outdated = True
            self._change(problem=None)

    def set_problem(self, reason: Message) -> None:
        """Note why the list or a survey cannot be read."""
        self._change(problem=reason)

    def verdict(self, survey: SurveySummary) -> Verdict:
        """Return how a survey ended; only one with every trace stored is complete."""
        if survey.problem is not None:
            return Verdict.UNREADABLE
        if self._running_id and survey.survey_id == self._running_id:
            return Verdict.RUNNING
        if survey.outcome == IMPORTED:
            return Verdict.IMPORTED
        return Verdict.COMPLETE if survey.complete else Verdict.INCOMPLETE

    def can_resume(self, survey: SurveySummary) -> bool:
        """Whether a survey lacks traces that could be measured now."""
        return (
            not self.replay and not self._running_id and self.verdict(survey) is Verdict.INCOMPLETE
        )

    def can_open(self, survey: SurveySummary) -> bool:
        """Whether there is something to show."""
        return survey.problem is None and survey.stored_traces > 0

    def can_analyze(self, survey: SurveySummary) -> bool:
        """Whether it can be searched for candidates or exported: never during a survey."""
        return self.can_open(survey) and not self._running_id and not self.replay

    def _change(self, problem: Optional[Message]) -> None:
        self.problem = problem
        self.revision += 1
