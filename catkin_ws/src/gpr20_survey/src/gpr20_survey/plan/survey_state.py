"""The states of a survey and of its planned samples."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Mapping, Optional

from gpr20_common.message import Message


class SurveyState(enum.IntEnum):
    """What the control is doing; the values are those of gpr20_msgs/ControlStatus."""

    IDLE = 0
    CONFIGURED = 1
    CHECKING = 2
    HOMING = 3
    SURVEYING = 4
    PAUSED = 5
    STOPPING = 6
    FINISHED = 7
    STOPPED = 8
    FAILED = 9
    PAUSING = 10

    @property
    def running(self) -> bool:
        """Whether a survey is in progress, paused or not."""
        return self in RUNNING

    @property
    def label(self) -> Message:
        return _LABELS[self]


RUNNING = frozenset(
    {
        *(SurveyState.CHECKING, SurveyState.HOMING, SurveyState.SURVEYING),
        *(SurveyState.PAUSING, SurveyState.PAUSED, SurveyState.STOPPING),
    }
)
ENDED = frozenset([SurveyState.FINISHED, SurveyState.STOPPED, SurveyState.FAILED])
_LABELS = {
    SurveyState.IDLE: Message("IDLE"),
    SurveyState.CONFIGURED: Message("CONFIGURED"),
    SurveyState.CHECKING: Message("CHECKING"),
    SurveyState.HOMING: Message("HOMING"),
    SurveyState.SURVEYING: Message("SURVEYING"),
    SurveyState.PAUSED: Message("PAUSED"),
    SurveyState.STOPPING: Message("STOPPING"),
    SurveyState.FINISHED: Message("FINISHED"),
    SurveyState.STOPPED: Message("STOPPED"),
    SurveyState.FAILED: Message("FAILED"),
    SurveyState.PAUSING: Message("PAUSING"),
}


class SampleState(enum.IntEnum):
    """State of one planned sample; the values are those of gpr20_msgs/SurveyCoverage."""

    NOT_VISITED = 0
    MEASURED = 1
    FAILED = 3


COVERAGE_LETTERS = {
    SampleState.NOT_VISITED: "-",
    SampleState.MEASURED: "m",
    SampleState.FAILED: "f",
}
"""Of the entry `coverage` of the report."""


@dataclass(frozen=True)
class Verdict:
    """The coverage in one sentence, and whether nothing is missing."""

    complete: bool
    message: Message


def reported_verdict(report: Any) -> Optional[Verdict]:
    """Return the verdict of a report as it was read; None if it has no coverage."""
    letters = report.get("coverage") if isinstance(report, Mapping) else None
    if not isinstance(letters, str) or not letters or set(letters) - set(COVERAGE_LETTERS.values()):
        return None
    failed = letters.count(COVERAGE_LETTERS[SampleState.FAILED])
    missing = letters.count(COVERAGE_LETTERS[SampleState.NOT_VISITED])
    return verdict(len(letters), failed, missing)


def verdict(planned: int, failed: int, missing: int) -> Verdict:
    """Return the verdict of numbers of samples."""
    stored = planned - failed - missing
    complete = Message("complete: all {planned} planned traces are stored", planned=planned)
    lacking = Message(
        "INCOMPLETE: {stored} of {planned} planned traces are stored, {failed} failed, {missing} "
        "not visited",
        stored=stored,
        planned=planned,
        failed=failed,
        missing=missing,
    )
    return Verdict(True, complete) if stored == planned else Verdict(False, lacking)
