"""How a survey ends: in one word for survey.json, and in the last status of its recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, NamedTuple, Tuple

from gpr20_common.message import Message
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.survey_state import SurveyState


class _Outcome(NamedTuple):
    sentence: Message
    states: Tuple[SurveyState, ...]
    """Of the last status; the first one where only the storage knows the end."""


OUTCOMES: Dict[str, _Outcome] = {
    "finished": _Outcome(Message("Finished"), (SurveyState.FINISHED,)),
    "stopped": _Outcome(Message("Stopped"), (SurveyState.STOPPED,)),
    "failed": _Outcome(Message("Failed"), (SurveyState.FAILED,)),
    # Without every trace, as a failed one; a main control that ends says that it has stopped.
    INTERRUPTED: _Outcome(
        Message("Interrupted before its end"), (SurveyState.FAILED, SurveyState.STOPPED)
    ),
}


@dataclass(frozen=True)
class SurveyEnd:
    """How a survey ended that nobody but the storage knows to have ended."""

    survey_id: str
    outcome: str
    """One of OUTCOMES."""
    reason: Message
    simulated: bool
    """Whether its data show no real ground."""
    time_ns: int
    """When it ended [ns since 1970, UTC]."""

    @property
    def state(self) -> SurveyState:
        """The state of its last status."""
        return OUTCOMES[self.outcome].states[0]

    @property
    def message(self) -> Message:
        """The sentence of its last status."""
        ended = OUTCOMES[self.outcome].sentence
        return Message("{outcome}: {reason}", outcome=ended, reason=self.reason)


def may_end_with(outcome: str, code: int) -> bool:
    """Return whether the last status of a survey with an outcome may have a state's code."""
    return outcome in OUTCOMES and code in OUTCOMES[outcome].states
