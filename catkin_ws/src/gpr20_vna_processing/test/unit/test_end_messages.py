from __future__ import annotations

import pytest

pytest.importorskip("gpr20_msgs.srv")

from gpr20_msgs.msg import ControlStatus
from gpr20_msgs.srv import CloseSurveyRequest
from gpr20_survey.errors import SurveyRefusedError
from gpr20_vna_processing.high.end_messages import end_messages

SURVEY, OTHER = "0f8fad5b-d9cb-469f-a165-70867728950e", "1f8fad5b-d9cb-469f-a165-70867728950e"
CODES = {
    "finished": {ControlStatus.FINISHED},
    "stopped": {ControlStatus.STOPPED},
    "failed": {ControlStatus.FAILED},
    # A main control that is shut down stops; it does not fail.
    "interrupted": {ControlStatus.STOPPED, ControlStatus.FAILED},
}


def request(outcome, code, survey_id=SURVEY):
    status = ControlStatus(code=code, survey_id=survey_id, message="the last one")
    return CloseSurveyRequest(survey_id=SURVEY, outcome=outcome, status=status)


@pytest.mark.parametrize("outcome", [*CODES, "", "lost"])
@pytest.mark.parametrize("code", range(11))
def test_the_last_status_must_state_the_outcome(outcome, code):
    if code in CODES.get(outcome, ()):
        (status,) = end_messages(request(outcome, code), 1)
        assert (status.topic, status.latching) == ("/control_status", True)
    else:
        with pytest.raises(SurveyRefusedError):
            end_messages(request(outcome, code), 1)


def test_the_last_status_must_be_of_the_same_survey():
    with pytest.raises(SurveyRefusedError):
        end_messages(request("finished", ControlStatus.FINISHED, OTHER), 1)


def test_without_a_status_nothing_is_recorded():
    assert end_messages(request("finished", 0, ""), 1) == []
