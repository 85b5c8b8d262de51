"""Whether a START or RESUME that the main control accepted fails afterwards."""

from __future__ import annotations

from typing import Optional

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Answer, ControlState, Request

BEGINNING = (SurveyState.CHECKING, SurveyState.HOMING)
NOT_BEGUN = (SurveyState.FAILED, SurveyState.PAUSED)


class RequestOutcome:
    """Detects that the checks after the acceptance fail.

    The main control answers before it checks the robot and homes the axes: only its status shows
    what fails then.
    """

    def __init__(self) -> None:
        self._request: Optional[Request] = None
        self._begun = False

    def asked(self, request: Request) -> None:
        """Note what the operator asks for."""
        self._request = request if request in (Request.START, Request.RESUME) else None
        self._begun = False

    def answered(self, answer: Answer) -> None:
        """Take an answer; a request that was refused has no outcome."""
        if answer.request is self._request and not answer.success:
            self._request = None

    def failed_request(self, state: ControlState) -> Optional[Request]:
        """Return the request that failed with this state, once; else None."""
        if self._request is None:
            return None
        if state.code in BEGINNING:
            self._begun = True
            return None
        # Until then the states are those from before the request.
        if not self._begun:
            return None
        request, self._request = self._request, None
        return request if state.code in NOT_BEGUN else None
