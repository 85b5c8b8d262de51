"""What a status of the main control says about a fault."""

from __future__ import annotations

from typing import Optional, Tuple, Union

from gpr20_common.message import Message, Severity
from gpr20_operator.robot.events import ControlState
from gpr20_survey.plan.survey_state import SurveyState


def reason_of(message: Message) -> Message:
    """Return what a status says without the words around it that name the state."""
    return message.failure or message


def is_fault(state: ControlState) -> bool:
    """Return whether a survey is paused or has ended because of a fault."""
    if state.code is SurveyState.FAILED:
        return True
    failed = state.message.failure is not None
    if state.code is SurveyState.PAUSED:
        # A text that does not say that the pause was asked for, as one of another version, is a
        # fault; a warning alone does not say it.
        return failed or not any(one.severity is Severity.NOTE for one in state.message.faults)
    return failed and state.code is SurveyState.STOPPED


def axis_may_move(state: ControlState) -> bool:
    """Return whether an axis may still move although the survey has ended."""
    message = state.message
    if state.code is not SurveyState.STOPPED:
        return message.may_move or is_fault(state)
    # A text without a fault, or a code that came without the rest, does not say that all is at
    # rest.
    cause = message.cause
    known = cause is not None and not (cause.severity is Severity.FAULT and cause.remedy is None)
    return message.may_move or not known


def is_notice(state: ControlState) -> bool:
    """Return whether a survey in progress warns, or waits: the operator must read it."""
    return bool(state.message.faults)


class FaultWatch:
    """Reports each fault of a survey once."""

    def __init__(self) -> None:
        self._told: Optional[Tuple[SurveyState, str, Union[str, Message]]] = None

    def note(self, state: Optional[ControlState]) -> Optional[ControlState]:
        """Take the status; return it if it is a fault that was not reported yet."""
        if state is None or not is_fault(state):
            self._told = None
            return None
        # Without the warnings around it, which may come and go.
        reason = reason_of(state.message)
        fault = state.code, state.survey_id, reason.fault_code or reason
        if fault == self._told:
            return None
        self._told = fault
        return state
