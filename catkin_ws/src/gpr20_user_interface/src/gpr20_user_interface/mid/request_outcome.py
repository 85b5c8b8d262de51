"""What becomes of a START or RESUME that main_control accepted."""

from __future__ import annotations

from typing import Optional

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Answer, ControlState, Request

BEGINNING = (SurveyState.CHECKING, SurveyState.HOMING)
CAME_TO_NOTHING = (SurveyState.FAILED, SurveyState.PAUSED)


class RequestOutcome:
    """Tells when the checks that follow the acceptance fail.

    main_control answers before it has checked the robot and homed the axes: what fails then is
    told by its status alone.
    """

    def __init__(self) -> None:
        self._request: Optional[Request] = None
        self._begun = False

    def asked(self, request: Request) -> None:
        """Take note of what the operator asks for."""
        self._request = request if request in (Request.START, Request.RESUME) else None
        self._begun = False

    def answered(self, answer: Answer) -> None:
        """Take note of an answer; what was refused has no outcome."""
        if answer.request is self._request and not answer.success:
            self._request = None

    def failed_request(self, state: ControlState) -> Optional[Request]:
        """Return the request that came to nothing with this state, once; else None."""
        if self._request is None:
            return None
        if state.code in BEGINNING:
            self._begun = True
            return None
        # Until then the states are those of what was before.
        if not self._begun:
            return None
        request, self._request = self._request, None
        return request if state.code in CAME_TO_NOTHING else None
