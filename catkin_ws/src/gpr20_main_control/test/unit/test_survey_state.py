"""The table of states."""

import pytest

from gpr20_common.message import Message
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_survey.plan.survey_state import (
    RUNNING,
    TRANSITIONS,
    SurveyState,
    TransitionError,
    check_transition,
)


def test_every_state_has_a_row_in_the_table():
    assert set(TRANSITIONS) == set(SurveyState)


@pytest.mark.parametrize("before", SurveyState)
@pytest.mark.parametrize("after", SurveyState)
def test_a_transition_that_is_not_in_the_table_is_refused(before, after):
    if after in TRANSITIONS[before]:
        check_transition(before, after)
    else:
        with pytest.raises(TransitionError, match=f"{before.name} .*{after.name}"):
            check_transition(before, after)


@pytest.mark.parametrize("state", sorted(RUNNING))
def test_every_running_survey_can_fail(state):
    assert SurveyState.FAILED in TRANSITIONS[state]


@pytest.mark.parametrize("state", sorted(RUNNING - {SurveyState.STOPPING}))
def test_every_running_survey_can_be_stopped(state):
    assert SurveyState.STOPPING in TRANSITIONS[state]


@pytest.mark.parametrize("state", sorted({*SurveyState} - RUNNING - {SurveyState.IDLE}))
def test_after_every_end_new_parameters_and_a_new_start_are_possible(state):
    assert SurveyState.CHECKING in TRANSITIONS[state]
    assert SurveyState.CONFIGURED in TRANSITIONS[state]


def test_an_illegal_transition_changes_nothing_and_tells_nobody():
    changes = []
    board = SurveyStatus(
        lambda before, after: changes.append(after), changes.append, changes.append
    )
    with pytest.raises(TransitionError):
        board.enter(SurveyState.SURVEYING, Message("Measuring"))
    assert board.status.state is SurveyState.IDLE
    assert changes == []
