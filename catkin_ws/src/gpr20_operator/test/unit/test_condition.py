"""The band follows what the robot does: its motion, its codes, and how old they are."""

from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from view_kit import (
    ASKED_PAUSE,
    ASKED_STOP,
    CLOCK,
    FULL,
    MOVING,
    RESTING,
    moving,
    paused,
    said,
    snapshot,
)

from gpr20_common.faults import BUSY
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    HealthLevel,
    HealthReport,
    NodeHealth,
)
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import Progress, Request
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import RUNNING, SurveyState

S, L = SurveyState, JobLevel
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
    going = {"progress": Progress("id", 50.0, 10, 5, 60.0)}
    for state, left in ((said(S.SURVEYING, verbatim("x")), True), (LATE, True), (None, False)):
        state = state or said(S.SURVEYING, WAITING)
        assert (left_of(snapshot(state=state, **going)) is not None) is left, state
    done = Progress("id", 100.0, 10, 10, 1.0)
    assert left_of(snapshot(state=said(S.SURVEYING, verbatim("x")), progress=done)) is None


CODES = st.none() | st.sampled_from(SurveyState)
MESSAGES = st.sampled_from(
    [verbatim("x"), FULL, MOVING, CLOCK.as_warning(), WAITING, ASKED_STOP, ASKED_PAUSE]
)
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
