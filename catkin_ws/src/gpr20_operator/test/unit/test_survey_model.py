import math
from dataclasses import replace

import pytest

from gpr20_common.message import verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    MeasuredHeight,
    Progress,
    Request,
    RobotDescribed,
    TargetPosition,
)
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, STALE_S, JobScreen
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState


def state(code, survey_id="id", simulated=False):
    return ControlState(code, verbatim("as it is"), survey_id, simulated)


PROGRESS = Progress("id", 50.0, 18, 9, 30.0)


@pytest.fixture
def model(clock):
    return SurveyModel(clock)


def allowed(snapshot):
    names = ("start", "pause", "resume")
    return [name for name in names if getattr(snapshot, f"can_{name}")]


def test_nothing_is_claimed_or_allowed_before_main_control_speaks(model):
    snapshot = model.snapshot()
    assert not snapshot.control_alive
    assert snapshot.control_silent_s is None
    assert (snapshot.state, snapshot.progress, snapshot.current, snapshot.height_m) == (None,) * 4
    assert allowed(snapshot) == []


def test_buttons_follow_what_main_control_says(model):
    extra = {SurveyState.PAUSED: ["resume"], SurveyState.SURVEYING: ["pause"]}
    for code in SurveyState:
        model.handle(state(code))
        expected = [] if code in RUNNING else ["start"]
        snapshot = model.snapshot()
        assert allowed(snapshot) == expected + extra.get(code, []), code
        assert snapshot.fields_locked == (code in RUNNING)
        # One that ends is not interrupted.
        model.handle(state(SurveyState.FINISHED))


def test_how_a_survey_ended_is_shown_though_another_plan_was_set_before_anybody_looked(model):
    job = JobScreen()
    model.handle(state(SurveyState.SURVEYING))
    model.handle(replace(PROGRESS, completion_percent=100.0))
    for end, level in ((SurveyState.FINISHED, JobLevel.DONE), (SurveyState.FAILED, JobLevel.FAULT)):
        model.handle(replace(state(SurveyState.CONFIGURED), end=end))
        snapshot = model.snapshot()
        assert not snapshot.interrupted and allowed(snapshot) == ["start"]
        condition = condition_of(snapshot)
        assert (condition.level, str(condition.title)) == (level, f"{end.name} 100 %")
        job.note(snapshot)
        assert job.visible
    # The next one begins.
    model.handle(state(SurveyState.CHECKING, "next"))
    assert str(condition_of(model.snapshot()).title) == "CHECKING"


def test_what_is_being_asked_for_is_asked_once(model):
    for code, request in (
        (SurveyState.CONFIGURED, Request.START),
        (SurveyState.SURVEYING, Request.PAUSE),
        (SurveyState.PAUSED, Request.RESUME),
    ):
        model.handle(state(code))
        before = allowed(model.snapshot())
        model.request_sent(request)
        assert allowed(model.snapshot()) == []
        model.handle(Answer(request, False, verbatim("no")))
        assert allowed(model.snapshot()) == before == [request.name.lower()]


def test_stop_that_was_asked_for_is_not_taken_for_done(model):
    model.handle(state(SurveyState.SURVEYING))
    model.request_sent(Request.STOP)
    assert allowed(model.snapshot()) == []
    model.handle(Answer(Request.STOP, True, verbatim("stopping")))
    snapshot = model.snapshot()
    assert snapshot.running and snapshot.fields_locked
    assert not snapshot.can_start


def test_start_stays_locked_between_its_answer_and_the_first_status(model, clock):
    model.handle(state(SurveyState.CONFIGURED, ""))
    model.request_sent(Request.START)
    model.handle(Answer(Request.START, True, verbatim("started"), "new"))
    assert allowed(model.snapshot()) == []
    model.handle(state(SurveyState.FAILED, "new"))
    assert allowed(model.snapshot()) == ["start"]
    # One that never shows locks it for a while only.
    model.request_sent(Request.START)
    model.handle(Answer(Request.START, True, verbatim("started"), "another"))
    clock.advance(CONTROL_SILENCE_S + 0.1)
    model.handle(state(SurveyState.IDLE, ""))
    assert allowed(model.snapshot()) == ["start"]


def test_silent_main_control_keeps_its_last_word_but_allows_no_start(model, clock):
    model.handle(state(SurveyState.FINISHED, simulated=True))
    clock.advance(CONTROL_SILENCE_S)
    assert model.snapshot().control_alive
    clock.advance(0.1)
    snapshot = model.snapshot()
    assert not snapshot.control_alive
    assert snapshot.control_silent_s == pytest.approx(CONTROL_SILENCE_S + 0.1)
    assert snapshot.state.code is SurveyState.FINISHED and snapshot.simulated
    assert allowed(snapshot) == []
    model.handle(PROGRESS)
    assert allowed(model.snapshot()) == ["start"]


def test_coordinates_and_height_that_are_old_are_not_shown_as_now(model, clock):
    model.handle(CurrentPosition(1.0, 2.0, 90.0))
    model.handle(TargetPosition(3.0, 4.0, 0.0))
    for height_m in (math.nan, math.inf, 0.3):
        assert model.snapshot().height_m is None, "out of range"
        model.handle(MeasuredHeight(height_m))
    clock.advance(STALE_S)
    snapshot = model.snapshot()
    assert snapshot.current == CurrentPosition(1.0, 2.0, 90.0)
    assert snapshot.target == TargetPosition(3.0, 4.0, 0.0)
    assert snapshot.height_m == 0.3
    clock.advance(0.1)
    snapshot = model.snapshot()
    assert (snapshot.current, snapshot.target, snapshot.height_m) == (None, None, None)


def test_limits_of_the_axes_stay_known_while_the_master_is_away(model):
    model.handle(state(SurveyState.IDLE))
    described = RobotDescribed(object())
    model.handle(described)
    assert model.snapshot().master_alive
    model.handle(MasterAnswered(False))
    assert model.snapshot().robot is described.robot
    assert not model.snapshot().master_alive
    model.handle(MasterAnswered(True))
    assert model.snapshot().master_alive
    model.handle(RobotDescribed(None, verbatim("no axes")))
    assert model.snapshot().robot is None


def test_an_axis_is_as_old_as_its_last_report(model, clock):
    model.handle(AxisReport(AxisId.X, 1.0, True, True))
    (axis,) = model.snapshot().axes
    assert (axis.received_s, axis.silent) == (clock.now_s(), False)
    clock.advance(STALE_S + 0.1)
    (axis,) = model.snapshot().axes
    assert axis.silent and axis.moving


def test_a_robot_stands_still_until_it_moves_measures_or_begins_something_else(model, clock):
    moves = AxisReport(AxisId.X, 1.0, True, True)
    rests = AxisReport(AxisId.X, 1.0, True, False)
    for event, progress in (
        *((state(SurveyState.CHECKING), True), (state(SurveyState.CHECKING), False)),
        *((state(SurveyState.SURVEYING), True), (PROGRESS, True), (PROGRESS, False)),
        *((moves, True), (moves, True), (rests, False), (CurrentPosition(1.0, 2.0, 3.0), False)),
        (replace(PROGRESS, visited_points=PROGRESS.visited_points + 1), True),
    ):
        clock.advance(4.0)
        model.handle(event)
        assert (model.snapshot().still_s == 0.0) is progress, event
    clock.advance(4.0)
    assert model.snapshot().still_s == 4.0


def test_survey_that_vanishes_with_its_main_control_is_told_until_the_next_one_runs(clock):
    for code in RUNNING:
        model = SurveyModel(clock)
        model.handle(state(code))
        assert not model.snapshot().interrupted
        # main_control begins in IDLE and knows nothing of what was.
        for begun in (SurveyState.IDLE, SurveyState.CONFIGURED):
            model.handle(state(begun, ""))
            assert model.snapshot().interrupted, code
        for code in (SurveyState.CHECKING, *ENDED, SurveyState.CONFIGURED):
            model.handle(state(code, "next"))
            assert not model.snapshot().interrupted
