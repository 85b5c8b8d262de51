"""What is known of a robot, what may be pressed, and the band: its motion, its codes, their age."""

import math
from dataclasses import replace

import pytest
from case_kit import each_case
from fake_clock import FakeClock
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import (
    ASKED_STOP,
    CLOCK,
    FULL,
    MOVING,
    RESTING,
    moving,
    paused,
    said,
    snapshot,
    state_of,
)

from gpr20_common.faults import BUSY
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, HealthReport, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import (
    Answer,
    CurrentPosition,
    Progress,
    Request,
    TargetPosition,
)
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, STALE_S, SurveyModel
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

S, L, R = SurveyState, JobLevel, Request
WAITING = Message("Waiting for the VNA: a sweep").with_fault(
    Fault("survey.takes_long", BUSY.remedy, Severity.WARNING)
)
LATE = said(S.SURVEYING, CLOCK.as_warning())
HOMING, STOP = verbatim("homing"), frozenset({Request.STOP})
SLOW = Progress("id", 0.0, 10, 0, 60.0)
# In these the survey itself may move the robot.
MOVES = (S.HOMING, S.SURVEYING, S.PAUSING, S.STOPPING)


def health(name, level, text="no answer"):
    return HealthReport((NodeHealth(name, level, verbatim(text), {}),))


NO_STORAGE = health("vna_processing", HealthLevel.STALE)
NO_VNA = health("vna_acquisition", HealthLevel.ERROR)


X_MOVES, BY_CONTROL = moving(AxisId.X), moving(AxisId.X, owner="/main_control")
BY_OTHER = moving(AxisId.Y, owner="/robot1/rqt_17")
SILENT = AxisReport(AxisId.X, 0.0, True, True, "", 0.0, silent=True)
TABLE = (
    # Each state by itself.
    *((code, {}, L.REST, code.name, "") for code in (S.IDLE, S.CONFIGURED, S.STOPPED)),
    *((code, {}, L.WORKING, code.name, "") for code in (S.CHECKING, S.HOMING, S.SURVEYING)),
    (S.PAUSING, {}, L.PAUSED, "PAUSING", ""),
    (S.STOPPING, {}, L.ATTENTION, "STOPPING", ""),
    (S.FINISHED, {}, L.DONE, "FINISHED", ""),
    (S.FAILED, {}, L.FAULT, "FAILED", ""),
    (None, {"state": paused(FULL)}, L.PAUSED, "PAUSED", "the disk is full"),
    (None, {"state": said(S.STOPPED, MOVING)}, L.FAULT, "STOPPED", "a motor runs"),
    # An axis homes after a survey, or another program moves one.
    (S.FINISHED, {"axes": X_MOVES}, L.ATTENTION, "ROBOT MOVES", "x axis"),
    (S.IDLE, {"axes": X_MOVES, "service": HOMING}, L.ATTENTION, "ROBOT MOVES", "service: homing"),
    # The state comes before the axis says that it rests; later, it moves.
    (S.FINISHED, {"axes": BY_CONTROL, "state_s": 0.4}, L.DONE, "FINISHED", ""),
    (S.FINISHED, {"axes": BY_CONTROL, "state_s": 0.6}, L.ATTENTION, "ROBOT MOVES", "main_control"),
    (S.FINISHED, {"service": HOMING}, L.ATTENTION, "SERVICE", "homing"),
    (S.SURVEYING, {"axes": BY_OTHER}, L.ATTENTION, "ROBOT MOVES", "y axis, by rqt_17"),
    (S.SURVEYING, {"axes": (SILENT,)}, L.ATTENTION, "ROBOT MOVES", "no report since it moved"),
    # The control is frozen, has died, or was never there.
    (S.SURVEYING, {"control_silent_s": 3.0}, L.ATTENTION, "SURVEYING", "for 3 s"),
    (S.SURVEYING, {"pending": STOP}, L.ATTENTION, "SURVEYING", "STOP was pressed"),
    (S.SURVEYING, {"alive": False}, L.FAULT, "NO CONTACT", "for 7 s"),
    (S.SURVEYING, {"alive": False, "axes": X_MOVES}, L.FAULT, "ROBOT MOVES", "for 7 s"),
    (S.IDLE, {"interrupted": True}, L.FAULT, "INTERRUPTED", "was restarted"),
    (S.SURVEYING, {"master_alive": False}, L.FAULT, "NO CONTACT", "ROS master"),
    (None, {"alive": False, "control_silent_s": None}, L.FAULT, "NO CONTACT", "roslaunch gpr20"),
    # The storage is dead, the survey waits, nothing happens for too long.
    (S.CHECKING, {"health": NO_STORAGE}, L.ATTENTION, "CHECKING", "No report: Storage"),
    (S.SURVEYING, {"health": NO_VNA}, L.ATTENTION, "SURVEYING", "VNA driver: no answer"),
    (None, {"state": said(S.SURVEYING, WAITING)}, L.ATTENTION, "SURVEYING", "Waiting for the VNA"),
    (None, {"state": LATE}, L.ATTENTION, "SURVEYING", "the clock is late"),
    (S.SURVEYING, {"still_s": 61.0}, L.ATTENTION, "SURVEYING", "No progress for 61 s"),
    (S.SURVEYING, {"still_s": 59.0, "progress": SLOW}, L.WORKING, "SURVEYING 0 %", ""),
)


@each_case("code,known,level,title,words", TABLE)
def test_the_band_says_what_the_robot_does(code, known, level, title, words):
    shown = condition_of(snapshot(**{"code": code, **known}))
    assert (shown.level, str(shown.title)) == (level, title)
    assert words in str(shown.message)


def test_a_time_is_left_only_while_it_passes():
    going = said(S.SURVEYING, verbatim("x"))
    for state, left in ((going, True), (LATE, True), (said(S.SURVEYING, WAITING), False)):
        shown = snapshot(state=state, progress=Progress("id", 50.0, 10, 5, 60.0))
        assert (left_of(shown) is not None) is left, state


CODES = st.none() | st.sampled_from(SurveyState)
MESSAGES = st.sampled_from([verbatim("x"), FULL, MOVING, CLOCK.as_warning(), WAITING, ASKED_STOP])
OWNERS = st.sampled_from(["", "/main_control", "/rqt"])
AXES = st.tuples(
    *(
        st.builds(
            *(AxisReport, st.just(axis), st.just(0.0), st.booleans(), st.booleans()),
            *(OWNERS, st.just(0.0), st.booleans()),
        )
        for axis in AxisId
    )
)
NODES = st.tuples(
    *(
        st.builds(NodeHealth, st.just(name), st.sampled_from(HealthLevel), MESSAGES, st.just({}))
        for name in EXPECTED_NODES
    )
)


@st.composite
def known(draw):
    """Return anything that a window may know of a robot."""
    code = draw(CODES)
    silent_s = draw(st.none() | st.floats(0.0, 100.0))
    return snapshot(
        state=None if code is None else said(code, draw(MESSAGES)),
        alive=silent_s is not None and silent_s <= 5.0,
        control_silent_s=silent_s,
        master_alive=draw(st.booleans()),
        interrupted=code not in RUNNING and draw(st.booleans()),
        still_s=draw(st.floats(0.0, 100.0)),
        service=draw(st.none() | st.just(verbatim("homing"))),
        axes=draw(st.just(RESTING) | AXES),
        health=draw(
            st.just(HealthReport()) | st.builds(HealthReport, NODES, settled=st.booleans())
        ),
        progress=draw(st.none() | st.just(Progress("id", 50.0, 10, 5, 10.0))),
    )


def is_of_survey(now, axis):
    """Return whether a survey that is alive, and no other program, moves an axis."""
    if not now.control_alive or axis.silent or axis.owner == "/rqt":
        return False
    return now.code in MOVES or (now.code is S.CHECKING and axis.owner == "/main_control")


@given(known())
def test_motion_that_no_survey_explains_is_shown_and_green_is_only_what_works(now):
    shown, stray = condition_of(now), [one for one in now.moving if not is_of_survey(now, one)]
    assert (str(shown.title) == "ROBOT MOVES") is bool(stray)
    if stray:
        assert shown.level in (L.ATTENTION, L.FAULT)
        assert all(f"{one.axis.value} axis" in str(shown.message) for one in stray)
    if shown.level is L.FAULT and now.code is not S.FAILED:
        assert shown.remedy is not None, str(shown.message)
    if left_of(now) is not None:
        assert now.code in (S.CHECKING, S.HOMING, S.SURVEYING, S.PAUSING)
        assert now.control_alive and now.master_alive and now.health.trouble is None
        assert now.state.message != WAITING and now.still_s <= 60.0
    if shown.level not in (L.WORKING, L.DONE, L.REST):
        return
    assert now.control_alive and now.master_alive and not now.interrupted
    assert now.control_silent_s <= 2.5
    assert now.health.trouble is None and now.service is None
    assert now.state is None or not now.state.is_fault
    if shown.level is L.WORKING:
        assert now.code in (S.CHECKING, S.HOMING, S.SURVEYING)
        assert now.still_s <= 60.0
        assert not any(one.severity is not Severity.NOTE for one in now.state.message.faults)
    else:
        assert not now.moving


PROGRESS = Progress("id", 50.0, 18, 9, 30.0)


@pytest.fixture
def model(clock):
    return SurveyModel(clock)


def allowed(snapshot):
    return {one for one in set(R) - {R.STOP} if getattr(snapshot, f"can_{one.value}")}


STEPS = st.one_of(
    st.sampled_from(S), st.sampled_from(R), st.tuples(st.sampled_from(R)), st.floats(0.0, 9.0)
)


@settings(max_examples=draws(100))
@given(st.lists(STEPS, max_size=20))
def test_what_may_be_pressed_follows_the_state_its_age_and_what_is_being_asked_for(steps):
    clock = FakeClock()
    model, code, heard_s, asked = SurveyModel(clock), None, -math.inf, set()
    for step in steps:
        if isinstance(step, S):
            code, heard_s = step, clock.now_s()
            model.handle(state_of(step))
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
        model.handle(state_of(S.CONFIGURED, survey_id=""))
        model.request_sent(R.START)
        model.handle(Answer(R.START, True, verbatim("started"), survey))
        assert not allowed(model.state())
        if seen:
            model.handle(state_of(S.FAILED, survey_id=survey))
        else:
            # One that never shows locks it for a while only.
            clock.advance(CONTROL_SILENCE_S + 0.1)
            model.handle(state_of(S.IDLE, survey_id=""))
        assert allowed(model.state()) == {R.START}


def test_how_a_survey_ended_is_shown_though_another_plan_was_set_before_anybody_looked(model):
    model.handle(state_of(S.SURVEYING))
    model.handle(replace(PROGRESS, completion_percent=100.0))
    for end, level in ((S.FINISHED, JobLevel.DONE), (S.FAILED, JobLevel.FAULT)):
        model.handle(replace(state_of(S.CONFIGURED), end=end))
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
        *((state_of(S.CHECKING), True), (state_of(S.CHECKING), False)),
        *((state_of(S.SURVEYING), True), (PROGRESS, True), (PROGRESS, False)),
        *((moves, True), (moves, True), (replace(moves, moving=False), False)),
        (replace(PROGRESS, visited_points=PROGRESS.visited_points + 1), True),
    ):
        clock.advance(4.0)
        model.handle(event)
        assert (model.state().still_s == 0.0) is progress, event


def test_survey_that_vanishes_with_its_main_control_is_said_until_the_next_one_runs(clock):
    for code in RUNNING:
        model = SurveyModel(clock)
        model.handle(state_of(code))
        assert not model.state().interrupted
        # main_control begins in IDLE and knows nothing of what was.
        for begun in (S.IDLE, S.CONFIGURED):
            model.handle(state_of(begun, survey_id=""))
            assert model.state().interrupted, code
        for after in (S.CHECKING, *ENDED, S.CONFIGURED):
            model.handle(state_of(after, survey_id="next"))
            assert not model.state().interrupted
