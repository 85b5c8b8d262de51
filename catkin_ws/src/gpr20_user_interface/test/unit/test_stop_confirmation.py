from dataclasses import replace

import pytest
from test_fault_messages import ASKED_STOP, FULL, MOVING
from view_kit import snapshot

from gpr20_common.message import in_a_row, verbatim
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_operator.robot.events import Answer, AxisReport, AxisStopAnswer, ControlState, Request
from gpr20_operator.robot.snapshot import STALE_S
from gpr20_operator.robot.stop_confirmation import ANSWER_S, EFFECT_S, REST_S, StopConfirmation
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState

ACCEPTED = Answer(Request.STOP, True, verbatim("stopping"))
NOTHING = Answer(Request.STOP, False, verbatim("no survey is running"))
SILENT = Answer(Request.STOP, False, verbatim("nobody there"), contact=False)
X, Y, Z = AxisId


class Robot:
    """What the window hears of a robot, and a STOP that it follows."""

    def __init__(self, clock):
        self.clock, self.stop = clock, StopConfirmation(clock)
        self.shown = snapshot(SurveyState.SURVEYING, axes=())
        self.report(X, Y, Z)

    def report(self, *axes, moving=False):
        """Let axes report a moment later."""
        self.clock.advance(0.001)
        kept = [one for one in self.shown.axes if one.axis not in axes]
        new = [
            AxisReport(axis, AxisPosition(0.0, True, moving), "", self.clock.now_s())
            for axis in axes
        ]
        self.shown = replace(self.shown, axes=(*kept, *new))

    def press(self, *answering):
        """Press STOP; these axes answer at once."""
        self.stop.press(self.shown)
        for axis in answering:
            self.stop.on_event(AxisStopAnswer(axis, True))

    def text(self):
        warning = self.stop.warning(self.shown)
        return "" if warning is None else str(warning.text)


@pytest.fixture
def robot(clock):
    return Robot(clock)


def test_a_stop_after_which_every_axis_rests_in_time_says_nothing(robot):
    robot.report(X, Y, moving=True)
    robot.press(X, Y, Z)
    robot.stop.on_event(ACCEPTED)
    robot.clock.advance(REST_S - 0.1)
    robot.report(X, Y, Z)
    assert not robot.text() and robot.stop.outcome is None
    robot.clock.advance(100.0)
    robot.report(X, moving=True)
    assert not robot.text()


def test_an_axis_that_does_not_rest_in_time_is_said_whatever_has_answered(robot):
    robot.report(Y, moving=True)
    robot.press(X, Y, Z)
    robot.stop.on_event(ACCEPTED)
    robot.clock.advance(REST_S)
    robot.report(X, Z)
    robot.report(Y, moving=True)
    warning = robot.stop.warning(robot.shown)
    assert str(warning.title) == "SWITCH OFF THE MOTORS' POWER"
    expected = "x axis: at rest; y axis: MOVES; z axis: at rest; main control: stopping"
    assert str(warning.text) == expected
    robot.report(Y)
    assert not robot.text()


def test_an_axis_that_does_not_answer_or_report_is_said_before_any_limit_runs_out(robot):
    robot.press(X, Z)
    robot.clock.advance(ANSWER_S)
    robot.report(X, Z)
    assert "y axis: no answer yet" in robot.text()
    robot.stop.on_event(AxisStopAnswer(Y, False))
    assert "y axis does NOT answer" in robot.text()
    # Its service hangs, but it says itself that it rests.
    robot.report(Y)
    assert not robot.text()
    # One that was silent before the press is said at the press.
    robot.stop.close()
    robot.clock.advance(STALE_S + 0.1)
    robot.report(X, Y)
    robot.press()
    assert "z axis: no answer yet" in robot.text()
    robot.shown = snapshot(axes=())
    robot.press()
    assert "x axis: no answer yet" in robot.text()


def test_a_report_or_a_status_from_before_the_press_proves_nothing(robot):
    robot.clock.advance(0.05)
    robot.press(X, Y, Z)
    robot.clock.advance(REST_S)
    assert robot.text()
    robot.stop.close()
    robot.shown = snapshot(SurveyState.STOPPED, axes=())
    robot.press()
    assert robot.text()


def test_a_move_that_a_slow_main_control_began_after_the_stop_is_said(robot):
    robot.press(X, Y, Z)
    robot.report(X, Y, Z)
    robot.clock.advance(REST_S)
    assert not robot.text()
    robot.report(X, moving=True)
    assert "x axis: MOVES" in robot.text()
    robot.stop.on_event(ACCEPTED)
    robot.clock.advance(EFFECT_S)
    robot.report(X, Y, Z)
    assert not robot.text()
    robot.report(X, moving=True)
    assert not robot.text(), "the STOP is over"


def test_the_answers_are_shown_where_no_survey_was_stopped(robot):
    for answer, words in ((NOTHING, ": no survey is running"), (SILENT, " does NOT answer")):
        robot.report(X, Y, Z)
        robot.press(X, Y, Z)
        robot.stop.on_event(answer)
        robot.clock.advance(EFFECT_S)
        robot.report(X, Y, Z)
        assert not robot.text()
        card = robot.stop.outcome
        assert str(card.title).startswith("Every axis rests.")
        assert f"z axis: at rest; main control{words}" in str(card.text)
        assert (card.then is not None) is (answer is SILENT)


def test_the_end_of_the_survey_confirms_a_stop_unless_an_axis_says_that_it_moves(robot):
    def ended(message):
        return replace(robot.shown, state=ControlState(SurveyState.STOPPED, message, "id", True))

    robot.shown = replace(robot.shown, axes=())
    robot.press()
    robot.stop.on_event(ACCEPTED)
    surveying = robot.shown
    for code in (SurveyState.SURVEYING, SurveyState.STOPPING):
        robot.shown = replace(surveying, state=ControlState(code, ASKED_STOP, "id", True))
        assert robot.text(), code
    robot.shown = ended(MOVING)
    assert robot.text()
    robot.shown = ended(in_a_row([ASKED_STOP, FULL]))
    robot.report(X, moving=True)
    assert robot.text()
    robot.report(X)
    # Recordings that were not finished leave no doubt about the stop.
    assert not robot.text()


def test_the_operator_can_close_it_and_press_again(robot):
    robot.shown = snapshot(axes=())
    assert not robot.text()
    for _ in range(2):
        robot.press()
        # Other answers confirm no stop.
        robot.stop.on_event(Answer(Request.PAUSE, True, verbatim("pausing")))
        assert robot.text()
        robot.stop.close()
        assert not robot.text()
