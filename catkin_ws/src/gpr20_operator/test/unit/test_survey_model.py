"""What is known of a robot and may be pressed, whatever came in which order."""

import math
from dataclasses import replace

import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    CurrentPosition,
    Progress,
    Request,
    TargetPosition,
)
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, STALE_S, SurveyModel
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

S, R = SurveyState, Request
PROGRESS = Progress("id", 50.0, 18, 9, 30.0)


def state(code, survey_id="id", **changes):
    return ControlState(code, verbatim("as it is"), survey_id, False, **changes)


@pytest.fixture
def model(clock):
    return SurveyModel(clock)


def allowed(snapshot):
    return {one for one in set(R) - {R.STOP} if getattr(snapshot, f"can_{one.value}")}


STEPS = st.one_of(
    st.sampled_from(S), st.sampled_from(R), st.tuples(st.sampled_from(R)), st.floats(0.0, 9.0)
)


@given(st.lists(STEPS, max_size=20))
def test_what_may_be_pressed_follows_the_state_its_age_and_what_is_being_asked_for(steps):
    clock = FakeClock()
    model, code, heard_s, asked = SurveyModel(clock), None, -math.inf, set()
    for step in steps:
        if isinstance(step, S):
            code, heard_s = step, clock.now_s()
            model.handle(state(step))
        elif isinstance(step, R):
            asked.add(step)
            model.request_sent(step)
        elif isinstance(step, float):
            clock.advance(step)
        else:
            asked -= {*step}
            refusal = model.handle(Answer(*step, False, verbatim("no")))
            # StopConfirmation says what became of a STOP.
            assert (refusal is None) == (step[0] is R.STOP)
        shown, can = model.state(), set()
        if clock.now_s() - heard_s <= CONTROL_SILENCE_S:
            can |= {R.START} if code not in RUNNING and R.START not in asked else set()
            can |= {R.PAUSE} if code is S.SURVEYING and not asked else set()
            can |= {R.RESUME} if code is S.PAUSED and not asked else set()
        assert allowed(shown) == can
        assert shown.fields_locked == (code in RUNNING or R.START in asked)
        assert shown.code is code, "the last word stays"


def test_start_stays_locked_between_its_answer_and_the_first_status(model, clock):
    for survey, seen in (("new", True), ("another", False)):
        model.handle(state(S.CONFIGURED, ""))
        model.request_sent(R.START)
        model.handle(Answer(R.START, True, verbatim("started"), survey))
        assert not allowed(model.state())
        if seen:
            model.handle(state(S.FAILED, survey))
        else:
            # One that never shows locks it for a while only.
            clock.advance(CONTROL_SILENCE_S + 0.1)
            model.handle(state(S.IDLE, ""))
        assert allowed(model.state()) == {R.START}


def test_how_a_survey_ended_is_shown_though_another_plan_was_set_before_anybody_looked(model):
    model.handle(state(S.SURVEYING))
    model.handle(replace(PROGRESS, completion_percent=100.0))
    for end, level in ((S.FINISHED, JobLevel.DONE), (S.FAILED, JobLevel.FAULT)):
        model.handle(state(S.CONFIGURED, end=end))
        snapshot = model.state()
        assert not snapshot.interrupted and allowed(snapshot) == {R.START}
        condition = condition_of(snapshot)
        assert (condition.level, str(condition.title)) == (level, f"{end.name} 100 %")


def test_what_is_old_is_not_shown_as_now(model, clock):
    place, target = CurrentPosition(1.0, 2.0, 90.0), TargetPosition(3.0, 4.0, 0.0)
    for event in (place, target, AxisReport(AxisId.X, 1.0, True, True)):
        model.handle(event)
    for pause_s, known in ((STALE_S, True), (0.1, False)):
        clock.advance(pause_s)
        shown = model.state()
        assert (shown.current, shown.target) == ((place, target) if known else (None, None))
        # An axis that fell silent while it moved counts as moving.
        assert shown.moving and shown.axes[0].silent is not known


def test_a_robot_stands_still_until_it_moves_measures_or_begins_something_else(model, clock):
    moves = AxisReport(AxisId.X, 1.0, True, True)
    for event, progress in (
        *((state(S.CHECKING), True), (state(S.CHECKING), False)),
        *((state(S.SURVEYING), True), (PROGRESS, True), (PROGRESS, False)),
        *((moves, True), (moves, True), (replace(moves, moving=False), False)),
        (replace(PROGRESS, visited_points=PROGRESS.visited_points + 1), True),
    ):
        clock.advance(4.0)
        model.handle(event)
        assert (model.state().still_s == 0.0) is progress, event


def test_survey_that_vanishes_with_its_main_control_is_said_until_the_next_one_runs(clock):
    for code in RUNNING:
        model = SurveyModel(clock)
        model.handle(state(code))
        assert not model.state().interrupted
        # main_control begins in IDLE and knows nothing of what was.
        for begun in (S.IDLE, S.CONFIGURED):
            model.handle(state(begun, ""))
            assert model.state().interrupted, code
        for after in (S.CHECKING, *ENDED, S.CONFIGURED):
            model.handle(state(after, "next"))
            assert not model.state().interrupted
