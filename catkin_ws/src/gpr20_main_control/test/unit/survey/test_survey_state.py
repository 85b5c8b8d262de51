"""The table of states."""

import itertools

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


def test_a_transition_that_is_not_in_the_table_is_refused():
    for before, after in itertools.product(SurveyState, repeat=2):
        if after in TRANSITIONS[before]:
            check_transition(before, after)
        else:
            with pytest.raises(TransitionError, match=f"{before.name} .*{after.name}"):
                print(before, after, check_transition(before, after))


def test_a_running_survey_can_fail_and_be_stopped_and_after_every_end_another_can_begin():
    for state in SurveyState:
        if state in RUNNING:
            assert SurveyState.FAILED in TRANSITIONS[state], state
        if state in RUNNING - {SurveyState.STOPPING}:
            assert SurveyState.STOPPING in TRANSITIONS[state], state
        if state not in RUNNING and state is not SurveyState.IDLE:
            assert {SurveyState.CHECKING, SurveyState.CONFIGURED} <= set(TRANSITIONS[state]), state


def test_an_illegal_transition_changes_nothing_and_tells_nobody():
    changes = []
    board = SurveyStatus(
        lambda before, after: changes.append(after), changes.append, changes.append
    )
    with pytest.raises(TransitionError):
        board.enter(SurveyState.SURVEYING, Message("Measuring"))
    assert board.status.state is SurveyState.IDLE
    assert changes == []
