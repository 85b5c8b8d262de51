"""What a status of the main control says about a fault."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState

# Messages of the main control that hold another one, and under which name.
_WRAPPERS = (
    ("Warning: ", "status"),
    ("Paused: ", "reason"),
    ("Paused on request, and a part failed: ", "reason"),
    ("Failed: ", "reason"),
)
_ON_REQUEST = "Paused on request."
_NOTICES = ("Warning: ", "Waiting")
# What may be wrong at the end of a survey that was stopped on request.
_STILL_MOVING = "AN AXIS IS STILL MOVING"
_BAD_ENDS = (_STILL_MOVING, "the recordings could not be finished")


def reason_of(message: Message) -> Message:
    """Return what a status says without the words around it that name the state."""
    for start, name in _WRAPPERS:
        inner = message.values.get(name)
        if message.template.startswith(start) and isinstance(inner, Message):
            return reason_of(inner)
    return message


def is_fault(state: ControlState) -> bool:
    """Return whether a survey is paused or has ended because of a fault."""
    if state.code is SurveyState.FAILED:
        return True
    if state.code is SurveyState.PAUSED:
        return not reason_of(state.message).sentence().startswith(_ON_REQUEST)
    if state.code is SurveyState.STOPPED:
        return any(one.template.startswith(_BAD_ENDS) for one in state.message.nested())
    return False


def axis_may_move(state: ControlState) -> bool:
    """Return whether an axis may still move although the survey has ended."""
    if state.code is SurveyState.STOPPED:
        return any(one.template.startswith(_STILL_MOVING) for one in state.message.nested())
    return is_fault(state)


def is_notice(state: ControlState) -> bool:
    """Return whether a status has something to say that the operator must read."""
    return state.message.sentence().startswith(_NOTICES)


class FaultWatch:
    """Reports each fault of a survey once."""

    def __init__(self) -> None:
        self._told: Optional[ControlState] = None

    def note(self, state: Optional[ControlState]) -> Optional[ControlState]:
        """Take the status; return it if it is a fault that was not reported yet."""
        if state is None or not is_fault(state):
            self._told = None
            return None
        if self._told is not None and _is_same(state, self._told):
            return None
        self._told = state
        return state


def _is_same(state: ControlState, other: ControlState) -> bool:
    same_survey = (state.code, state.survey_id) == (other.code, other.survey_id)
    # Without the warnings around it, which may come and go.
    return same_survey and reason_of(state.message) == reason_of(other.message)
