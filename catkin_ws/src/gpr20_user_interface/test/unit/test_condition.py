"""The band follows what the robot does: its motion, its codes, and how old they are."""

import dataclasses
import itertools

from hypothesis import given
from hypothesis import strategies as st
from test_fault_messages import ASKED_PAUSE, ASKED_STOP, CLOCK, FULL, MOVING, paused
from view_kit import RESTING, moving, snapshot, state_of

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth, node_title
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_operator import faults
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import AxisReport, ControlState, Progress, Request
from gpr20_operator.robot.health import NOT_NEEDED, STALE_S, HealthReport, HealthTracker
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

S, L = SurveyState, JobLevel
MOVES_NOW = AxisPosition(0.0, True, True)
WAITING = Message("Waiting for the VNA: a sweep").with_fault(
    Fault("survey.takes_long", remedies.TRY_LATER, Severity.WARNING)
)
NEEDED = [name for name in EXPECTED_NODES if name not in NOT_NEEDED]
# In these the survey itself may move the robot.
MOVES = (S.HOMING, S.SURVEYING, S.PAUSING, S.STOPPING)


def health(name, level, text="no answer"):
    return HealthReport((NodeHealth(name, level, verbatim(text), {}),))


def said(code, message):
    return ControlState(code, message, "id", True)


# What the issue and the documentation say: what is known, the level, words of title and message.
TABLE = (
    # Each state by itself.
    ({"code": S.IDLE}, L.REST, "IDLE", "as it is"),
    ({"code": S.CONFIGURED}, L.REST, "CONFIGURED", ""),
    ({"code": S.CHECKING}, L.WORKING, "CHECKING", ""),
    ({"code": S.HOMING}, L.WORKING, "HOMING", ""),
    ({"code": S.SURVEYING}, L.WORKING, "SURVEYING", ""),
    ({"code": S.PAUSING}, L.PAUSED, "PAUSING", ""),
    ({"code": S.STOPPING}, L.ATTENTION, "STOPPING", ""),
    ({"code": S.FINISHED}, L.DONE, "FINISHED", ""),
    ({"code": S.STOPPED}, L.REST, "STOPPED", ""),
    ({"code": S.FAILED}, L.FAULT, "FAILED", ""),
    ({"state": paused(FULL)}, L.PAUSED, "PAUSED", "the disk is full"),
    ({"state": said(S.PAUSED, ASKED_PAUSE)}, L.PAUSED, "PAUSED", ""),
    ({"state": said(S.STOPPED, MOVING)}, L.FAULT, "STOPPED", "a motor runs"),
    # An axis homes after a survey, or another program moves one.
    ({"code": S.FINISHED, "axes": moving(AxisId.X)}, L.ATTENTION, "ROBOT MOVES", "x axis"),
    (
        {"code": S.IDLE, "axes": moving(AxisId.X), "service": verbatim("homing")},
        *(L.ATTENTION, "ROBOT MOVES", "in service: homing"),
    ),
    ({"code": S.CHECKING, "axes": moving(AxisId.X)}, L.ATTENTION, "ROBOT MOVES", "x axis"),
    (
        {"code": S.CHECKING, "axes": moving(AxisId.X, owner="/main_control")},
        L.WORKING,
        "CHECKING",
        "",
    ),
    # The state comes before the axis says that it rests; later, it moves.
    (
        {"code": S.FINISHED, "axes": moving(AxisId.X, owner="/main_control"), "state_s": 0.4},
        *(L.DONE, "FINISHED", ""),
    ),
    (
        {"code": S.FINISHED, "axes": moving(AxisId.X, owner="/main_control"), "state_s": 0.6},
        *(L.ATTENTION, "ROBOT MOVES", "x axis, by main_control"),
    ),
    ({"code": S.FINISHED, "service": verbatim("homing")}, L.ATTENTION, "SERVICE", "homing"),
    (
        {"code": S.SURVEYING, "axes": moving(AxisId.Y, owner="/rqt")},
        *(L.ATTENTION, "ROBOT MOVES", "y axis, by rqt"),
    ),
    (
        {"code": S.SURVEYING, "axes": (AxisReport(AxisId.X, MOVES_NOW, "", 0.0, silent=True),)},
        *(L.ATTENTION, "ROBOT MOVES", "no report since it moved"),
    ),
    # The control is frozen, has died, or was never there.
    ({"code": S.SURVEYING, "control_silent_s": 3.0}, L.ATTENTION, "SURVEYING", "for 3 s"),
    (
        {"code": S.SURVEYING, "pending": frozenset({Request.STOP})},
        *(L.ATTENTION, "SURVEYING", "STOP was pressed"),
    ),
    ({"code": S.STOPPING, "pending": frozenset({Request.STOP})}, L.ATTENTION, "STOPPING", ""),
    ({"code": S.SURVEYING, "alive": False}, L.FAULT, "NO CONTACT", "for 7 s"),
    (
        {"code": S.SURVEYING, "alive": False, "axes": moving(AxisId.X)},
        *(L.FAULT, "ROBOT MOVES", "No contact with the main control for 7 s"),
    ),
    ({"code": S.IDLE, "interrupted": True}, L.FAULT, "INTERRUPTED", "was restarted"),
    ({"code": S.SURVEYING, "master_alive": False}, L.FAULT, "NO CONTACT", "ROS master"),
    (
        {"code": None, "alive": False, "control_silent_s": None},
        *(L.FAULT, "NO CONTACT", "roslaunch gpr20 survey.launch"),
    ),
    # The storage is dead, there is no VNA, the survey waits.
    (
        {"code": S.CHECKING, "health": health("vna_processing", HealthLevel.STALE)},
        *(L.ATTENTION, "CHECKING", "No report: Storage"),
    ),
    (
        {"code": S.SURVEYING, "health": health("vna_acquisition", HealthLevel.ERROR)},
        *(L.ATTENTION, "SURVEYING", "VNA driver: no answer"),
    ),
    ({"state": said(S.SURVEYING, WAITING)}, L.ATTENTION, "SURVEYING", "Waiting for the VNA"),
    (
        {"state": said(S.SURVEYING, CLOCK.as_warning())},
        *(L.ATTENTION, "SURVEYING", "the clock is late"),
    ),
    # Nothing happens for longer than it should.
    ({"code": S.SURVEYING, "still_s": 11.0}, L.ATTENTION, "SURVEYING", "No progress for 11 s"),
    ({"code": S.CHECKING, "still_s": 21.0}, L.ATTENTION, "CHECKING", "No progress for 21 s"),
    # A sweep of a slow analyzer takes long.
    (
        {"code": S.SURVEYING, "still_s": 20.0, "progress": Progress("id", 0.0, 10, 0, 60.0)},
        *(L.WORKING, "SURVEYING 0 %", ""),
    ),
)


def test_the_band_says_what_the_robot_does():
    for known, level, title, words in TABLE:
        shown = condition_of(snapshot(**{"code": None, **known}))
        found = shown.level, str(shown.title)
        assert found == (level, title), (known, found)
        assert words in str(shown.message), (known, str(shown.message))


def test_hands_stay_clear_of_an_interrupted_robot_until_every_axis_says_that_it_rests():
    at_rest = tuple(dataclasses.replace(one, silent=False) for one in RESTING)
    silent = dataclasses.replace(at_rest[0], silent=True)
    for axes, words in (
        (at_rest, "Resume the survey on SURVEY"),
        ((), "the axes may still move"),
        (at_rest[:2], "the axes may still move"),
        ((silent, *at_rest[1:]), "the axes may still move"),
    ):
        shown = condition_of(snapshot(code=S.IDLE, interrupted=True, axes=axes))
        assert words in str(shown.remedy), axes


CODES = st.none() | st.sampled_from(SurveyState)
MESSAGES = st.sampled_from(
    [verbatim("x"), FULL, MOVING, CLOCK.as_warning(), WAITING, ASKED_STOP, ASKED_PAUSE]
)
AXES = st.tuples(
    *(
        st.builds(
            AxisReport,
            st.just(axis),
            st.builds(AxisPosition, st.just(0.0), st.booleans(), st.booleans()),
            st.sampled_from(["", "/main_control", "/rqt"]),
            st.just(0.0),
            st.booleans(),
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


@given(known())
def test_motion_that_no_survey_explains_is_never_shown_as_rest_or_work(now):
    shown, stray = condition_of(now), [one for one in now.moving if not is_of_survey(now, one)]
    assert (str(shown.title) == "ROBOT MOVES") is bool(stray)
    if stray:
        assert shown.level in (L.ATTENTION, L.FAULT)
        assert all(f"{one.axis.value} axis" in str(shown.message) for one in stray)


def is_of_survey(now, axis):
    """Return whether a survey that is alive, and no other program, moves an axis."""
    if not now.control_alive or axis.silent or axis.owner == "/rqt":
        return False
    return now.code in MOVES or (now.code is S.CHECKING and axis.owner == "/main_control")


@given(known())
def test_only_a_robot_that_works_is_green_and_only_one_that_rests_has_finished(now):
    shown = condition_of(now)
    if shown.level not in (L.WORKING, L.DONE, L.REST):
        return
    assert now.control_alive and now.master_alive and not now.interrupted
    assert now.control_silent_s <= 2.5
    assert now.health.trouble is None and now.service is None
    assert now.state is None or not now.state.is_fault
    if shown.level is L.WORKING:
        assert now.code in (S.CHECKING, S.HOMING, S.SURVEYING)
        assert now.still_s <= 23.0
        assert not any(one.severity is not Severity.NOTE for one in now.state.message.faults)
    else:
        assert not now.moving


@given(known())
def test_who_must_do_something_can_read_what(now):
    shown = condition_of(now)
    if shown.level is L.FAULT and now.code is not S.FAILED:
        assert shown.remedy is not None, str(shown.message)
    if any(one.moving and not one.silent for one in now.axes) and shown.level is L.FAULT:
        assert shown.message.may_move or now.code in MOVES


@given(known())
def test_time_is_left_only_while_it_passes(now):
    if left_of(now) is None:
        return
    assert now.code in (S.CHECKING, S.HOMING, S.SURVEYING, S.PAUSING)
    assert now.control_alive and now.master_alive and now.health.trouble is None
    assert now.state.message != WAITING and now.still_s <= 23.0


def test_a_part_that_a_survey_needs_is_named_within_five_seconds(clock):
    for name, code in itertools.product(NEEDED, (*RUNNING, S.IDLE, *ENDED)):
        model = SurveyModel(clock)
        for _second in range(10):
            clock.advance(1.0)
            model.handle(state_of(code))
            for one in EXPECTED_NODES:
                model.handle(NodeHealth(one, HealthLevel.OK, verbatim("fine"), {}))
        assert "No report" not in str(condition_of(model.snapshot()).message)
        for _second in range(5):
            clock.advance(1.0)
            model.handle(state_of(code))
            for one in EXPECTED_NODES:
                if one != name:
                    model.handle(NodeHealth(one, HealthLevel.OK, verbatim("fine"), {}))
        shown = condition_of(model.snapshot())
        if code not in (S.PAUSED, S.FAILED):  # their own reason comes first
            assert str(node_title(name)) in str(shown.message), (name, code)
            assert shown.level not in (L.WORKING, L.DONE, L.REST)
            assert shown.message.fault_code == faults.PART_SILENT.code


def test_the_web_page_is_listed_once_it_has_reported_and_no_survey_misses_it(clock):
    tracker = HealthTracker(clock)
    assert tracker.report().node("web") is None
    tracker.note(NodeHealth("web", HealthLevel.OK, verbatim("fine"), {}))
    assert tracker.report().node("web").level is HealthLevel.OK
    clock.advance(STALE_S + 0.1)
    report = tracker.report()
    assert report.node("web").level is HealthLevel.STALE
    assert str(node_title("web")) not in str(report.trouble)


def test_nodes_have_the_time_to_report_once(clock):
    tracker = HealthTracker(clock)
    assert tracker.report().trouble is None
    clock.advance(STALE_S + 0.1)
    assert "Storage" in str(tracker.report().trouble)


def test_images_can_wait():
    for name in NOT_NEEDED:
        assert health(name, HealthLevel.STALE).trouble is None
        assert health(name, HealthLevel.ERROR).trouble is None
