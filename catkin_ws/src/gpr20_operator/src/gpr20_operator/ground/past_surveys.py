"""The list of past surveys: how each ended, what can be done with it, and what is searched for."""

from __future__ import annotations

import enum
import unicodedata
from typing import Callable, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.words import local_time
from gpr20_survey.plan.recorded_plan import IMPORTED
from gpr20_survey.results.answers import SurveySummary

Shown = Callable[[Message], str]


class Ending(enum.Enum):
    """How a survey ended."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    RUNNING = "running"
    UNREADABLE = "unreadable"
    IMPORTED = "imported"
    """It has no plan: nothing says whether it is complete."""


def survey_label(name: str, survey_id: str, begun: Message) -> Message:
    """Return what a survey is called on every page: when it began, and its name."""
    called = name or survey_id[:8]
    return Message("{time}, {name}", time=begun, name=called) if str(begun) else verbatim(called)


def past_band(label: Message, outcome: str) -> Message:
    """Return what pages say of a survey that is not the one of the robot."""
    if outcome == IMPORTED:
        return Message("IMPORTED SURVEY: {name}", name=label)
    return Message("PAST SURVEY: {name}", name=label)


def searchable(text: str) -> str:
    """Return a text as it is compared: without capital letters and accents."""
    letters = unicodedata.normalize("NFKD", text).casefold()
    return "".join(one for one in letters if not unicodedata.combining(one))


class PastSurveys:
    """Collects the pages of the list; knows which survey is running.

    Attributes:
        revision: Changes with everything that a view shows of this.
        surveys: The surveys of the pages so far, the newest first.
        outdated: Whether the list should be requested again when it is visible.
        problem: Why the list or a survey cannot be read; None if it can.
        read: Whether a page has come.
        more: Whether there are older ones.
    """

    def __init__(self) -> None:
        self.revision = 0
        self.surveys: Tuple[SurveySummary, ...] = ()
        self.outdated = self.read = self.more = False
        self.problem: Optional[Message] = None
        self._running_id = ""

    @property
    def next_before(self) -> str:
        """Folder before which the next page begins; empty: the first page."""
        return self.surveys[-1].folder if self.surveys else ""

    def title_of(self, survey: SurveySummary) -> Message:
        """Return what people call a survey: its name, or when it was measured, and its id."""
        # That of a folder of others may have several lines.
        name = " ".join(survey.name.split())
        begun = local_time(survey.started, survey.folder)
        return verbatim(name) if name else survey_label("", survey.survey_id, begun)

    def find(self, folder: str) -> Optional[SurveySummary]:
        return next((one for one in self.surveys if one.folder == folder), None)

    def found(self, text: str, shown: Shown) -> Tuple[SurveySummary, ...]:
        """Return those whose names, time and ending as shown have each word of a text."""
        words = searchable(text).split()

        def has_words(one: SurveySummary) -> bool:
            said = map(shown, (local_time(one.started, one.folder), self.ending(one)))
            written = searchable("\n".join((one.name, one.site, one.operator, *said)))
            return all(word in written for word in words)

        return tuple(one for one in self.surveys if not words or has_words(one))

    def take(self, before: str, surveys: Tuple[SurveySummary, ...], more: bool) -> None:
        """Add a page; the first one replaces the list."""
        self.set_problem(None)
        if before and before != self.next_before:
            return  # the list was replaced meanwhile
        self.surveys = (*self.surveys, *surveys) if before else surveys
        self.more, self.read = more, True

    def set_running(self, survey_id: str) -> None:
        """Note which survey is running; empty: none."""
        if survey_id != self._running_id:
            self._running_id = survey_id
            self.set_outdated()

    def set_outdated(self) -> None:
        """Note that the surveys have changed."""
        self.outdated = True
        self.set_problem(None)

    def set_problem(self, problem: Optional[Message]) -> None:
        """Note why the list or a survey cannot be read; None: it can."""
        self.problem = problem
        self.revision += 1

    def ending_of(self, survey: SurveySummary) -> Ending:
        """Return how a survey ended; only one with every trace stored is complete."""
        if survey.problem is not None:
            return Ending.UNREADABLE
        if self._running_id and survey.survey_id == self._running_id:
            return Ending.RUNNING
        if survey.outcome == IMPORTED:
            return Ending.IMPORTED
        return Ending.COMPLETE if survey.complete else Ending.INCOMPLETE

    def ending(self, survey: SurveySummary) -> Message:
        """Return in a few words how a survey ended; of an incomplete one, what is wrong with it."""
        ending, planned = self.ending_of(survey), survey.planned_traces
        if ending is not Ending.INCOMPLETE:
            return {
                Ending.COMPLETE: Message("complete"),
                Ending.RUNNING: Message("running"),
                Ending.UNREADABLE: Message("cannot be read"),
                Ending.IMPORTED: Message("imported"),
            }[ending]
        if not planned:
            return Message("its plan cannot be read")
        missing = planned - survey.stored_traces
        if missing > 0:
            return Message(
                "{missing} of {planned} traces missing", missing=missing, planned=planned
            )
        return Message("not confirmed; all traces stored")

    def can_resume(self, survey: SurveySummary) -> bool:
        """Whether a survey could be measured to its end now."""
        return self.ending_of(survey) is Ending.INCOMPLETE and not self._running_id

    def can_open(self, survey: SurveySummary) -> bool:
        """Whether there is something to show."""
        return survey.problem is None and survey.stored_traces > 0

    def can_analyze(self, survey: SurveySummary) -> bool:
        """Whether it can be searched for candidates or exported: never during a survey."""
        return self.can_open(survey) and not self._running_id
