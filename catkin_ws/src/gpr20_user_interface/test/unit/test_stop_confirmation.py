from dataclasses import replace

import pytest
from test_fault_messages import ASKED_STOP, FULL, MOVING
from test_job import snapshot

from gpr20_common.message import in_a_row, verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Answer, ControlState, Request
from gpr20_user_interface.mid.robot_health import HealthReport
from gpr20_user_interface.mid.stop_confirmation import ANSWER_S, AXIS_NODES, StopConfirmation

SURVEYING = snapshot(SurveyState.SURVEYING)
STOPPED = snapshot(
    SurveyState.STOPPED, state=ControlState(SurveyState.STOPPED, ASKED_STOP, "id", True)
)
NO_MASTER = snapshot(SurveyState.SURVEYING, master_alive=False)
ACCEPTED = Answer(Request.STOP, True, verbatim("stopping"))
NOBODY = Answer(Request.STOP, False, verbatim("x does NOT answer"), contact=False)


@pytest.fixture
def stop(clock):
    return StopConfirmation(clock)


def axes(level):
    control = NodeHealth("main_control", HealthLevel.OK, verbatim(""), {})
    nodes = tuple(NodeHealth(name, level, verbatim(""), {}) for name in AXIS_NODES)
    return HealthReport((control, *nodes))


def test_a_stop_that_is_answered_in_time_says_nothing(stop, clock):
    stop.press(SURVEYING)
    assert stop.warning(SURVEYING) is None
    stop.on_event(ACCEPTED)
    clock.advance(10.0)
    assert stop.warning(SURVEYING) is None


def test_a_stop_without_an_answer_is_said_before_any_time_limit_runs_out(stop, clock):
    stop.press(SURVEYING)
    clock.advance(ANSWER_S)
    assert "MOTORS' POWER" in str(stop.warning(SURVEYING).title)
    stop.on_event(NOBODY)
    assert str(stop.warning(SURVEYING).text) == "x does NOT answer"
    stop.on_event(ACCEPTED)
    assert stop.warning(SURVEYING) is None


def test_a_stop_that_can_hardly_work_is_said_at_the_press(stop):
    for doubtful, words in (
        (NO_MASTER, "ROS master"),
        (snapshot(SurveyState.SURVEYING, alive=False), "main control"),
        (snapshot(SurveyState.SURVEYING, health=axes(HealthLevel.STALE)), "No axis"),
    ):
        stop.press(doubtful)
        assert words in str(stop.warning(doubtful).text)


def test_axes_are_not_silent_that_report_or_where_no_node_reports(stop):
    nodes = tuple(NodeHealth(name, HealthLevel.STALE, verbatim(""), {}) for name in AXIS_NODES)
    for health in (axes(HealthLevel.OK), HealthReport(nodes)):
        known = snapshot(SurveyState.SURVEYING, health=health)
        stop.press(known)
        assert stop.warning(known) is None


def test_silent_axes_that_answer_themselves_confirm_the_stop(stop):
    silent = snapshot(SurveyState.SURVEYING, health=axes(HealthLevel.STALE))
    stop.press(silent)
    stop.on_event(Answer(Request.STOP, False, verbatim("x axis: stopping"), contact=True))
    assert stop.warning(silent) is None


def test_silent_axes_are_believed_to_rest_only_at_the_end(stop):
    silent = snapshot(SurveyState.SURVEYING, health=axes(HealthLevel.STALE))
    stop.press(silent)
    stop.on_event(ACCEPTED)
    assert stop.warning(snapshot(SurveyState.STOPPING)) is not None
    bad = ControlState(SurveyState.STOPPED, MOVING, "id", True)
    assert stop.warning(snapshot(SurveyState.STOPPED, state=bad)) is not None
    assert stop.warning(STOPPED) is None


def test_without_a_master_only_the_end_of_the_survey_confirms_a_stop(stop):
    stop.press(NO_MASTER)
    stop.on_event(ACCEPTED)
    for code in (SurveyState.SURVEYING, SurveyState.STOPPING):
        warning = stop.warning(snapshot(code, master_alive=False))
        assert "ROS master" in str(warning.text)
    assert stop.warning(replace(STOPPED, master_alive=False)) is None


def test_recordings_that_were_not_finished_leave_no_doubt_about_the_stop(stop):
    stop.press(NO_MASTER)
    ended = ControlState(SurveyState.STOPPED, in_a_row([ASKED_STOP, FULL]), "id", True)
    assert stop.warning(snapshot(SurveyState.STOPPED, state=ended)) is None


def test_an_old_status_confirms_nothing(stop):
    ended = snapshot(SurveyState.STOPPED, master_alive=False)
    stop.press(ended)
    assert stop.warning(ended) is not None
    stop.on_event(Answer(Request.STOP, False, verbatim("no survey is running")))
    assert stop.warning(ended) is None


def test_the_operator_can_close_it_and_press_again(stop):
    assert stop.warning(NO_MASTER) is None
    for _ in range(2):
        stop.press(NO_MASTER)
        # Other answers confirm no stop.
        stop.on_event(Answer(Request.PAUSE, True, verbatim("pausing")))
        assert stop.warning(NO_MASTER) is not None
        stop.close()
        assert stop.warning(NO_MASTER) is None
