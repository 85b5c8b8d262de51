import pytest

from gpr20_common.message import verbatim
from gpr20_operator.robot.events import Answer, ControlState, Request
from gpr20_operator.robot.survey_model import RequestOutcome
from gpr20_survey.plan.survey_state import SurveyState


@pytest.fixture
def outcome():
    return RequestOutcome()


def printed(outcome, *codes):
    return [
        outcome.failed_request(ControlState(code, verbatim("why"), "id", False)) for code in codes
    ]


def test_checks_that_fail_after_the_acceptance_are_told_once(outcome):
    ends = (SurveyState.FAILED, SurveyState.PAUSED)
    for request in (Request.START, Request.RESUME):
        for end in ends:
            for before in (*ends, SurveyState.CONFIGURED):
                outcome.asked(request)
                codes = (before, SurveyState.CHECKING, SurveyState.HOMING, end, end)
                assert printed(outcome, *codes) == [None, None, None, request, None], codes


def test_survey_that_came_to_measure_may_fail_later_for_other_reasons(outcome):
    outcome.asked(Request.START)
    codes = (SurveyState.CHECKING, SurveyState.SURVEYING, SurveyState.PAUSED, SurveyState.FAILED)
    assert printed(outcome, *codes) == [None] * 4


def test_checks_that_are_stopped_have_not_failed(outcome):
    outcome.asked(Request.START)
    outcome.failed_request(ControlState(SurveyState.CHECKING, verbatim(""), "id", False))
    outcome.asked(Request.STOP)
    assert printed(outcome, SurveyState.STOPPING, SurveyState.FAILED) == [None, None]


def test_what_was_refused_or_asked_by_others_is_not_told_again(outcome):
    assert printed(outcome, SurveyState.CHECKING, SurveyState.FAILED) == [None, None]
    outcome.asked(Request.START)
    outcome.answered(Answer(Request.START, False, verbatim("no")))
    assert printed(outcome, SurveyState.CHECKING, SurveyState.FAILED) == [None, None]
