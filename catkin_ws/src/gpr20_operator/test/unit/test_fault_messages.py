"""Card, band and STOP follow the faults of a status, whatever its words and its version."""

from dataclasses import replace

import pytest

pytest.importorskip("rospy")

from fake_clock import FakeClock
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import (
    ASKED_PAUSE,
    ASKED_STOP,
    CLOCK,
    FULL,
    LOST,
    MOVING,
    PAUSED,
    moving,
    paused,
    said,
    snapshot,
)

from gpr20_common.faults import MAY_MOVE
from gpr20_common.message import Fault, Message, in_a_row, verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.notices import (
    ANSWER_S,
    EFFECT_S,
    REST_S,
    CardWatch,
    Refused,
    StopConfirmation,
    fault_notice,
    refusal_notice,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import COMPLETE
from gpr20_survey.plan.survey_state import ENDED, SurveyState


def warned(status):
    return Message("Warning: {warning}. {status}", warning=CLOCK.as_warning(), status=status)


def test_a_pause_or_an_end_is_a_fault_unless_it_was_asked_for():
    paused_, stopped, failed = SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED
    for code, message, fault in (
        *((code, FULL, False) for code in set(SurveyState) - {paused_, *ENDED}),
        *((failed, verbatim("x"), True), (failed, ASKED_STOP, True)),
        *((paused_, Message(PAUSED, reason=FULL), True), (paused_, ASKED_PAUSE, False)),
        *((paused_, warned(ASKED_PAUSE), False), (paused_, verbatim("x"), True)),
        (paused_, Message("{a}, but {b}", a=ASKED_PAUSE, b=FULL), True),
        *((stopped, ASKED_STOP, False), (stopped, in_a_row([ASKED_STOP, FULL]), True)),
        (SurveyState.FINISHED, warned(verbatim("x")), False),
    ):
        assert said(code, message).is_fault is fault, (code, message)


def test_resume_is_not_offered_for_a_survey_that_cannot_continue():
    for code in (SurveyState.PAUSED, SurveyState.FAILED):
        assert not fault_notice(said(code, Message(PAUSED, reason=LOST))).resumable
    notice = refusal_notice(Refused.RESUME, Message("{reason}", reason=LOST))
    assert notice.first == COMPLETE.remedy and notice.then is None
    assert refusal_notice(Refused.RESUME, FULL).then is not None


def test_a_lost_contact_opens_a_card_only_where_something_may_move():
    on, rest = said(SurveyState.SURVEYING, ASKED_PAUSE), said(SurveyState.IDLE, ASKED_STOP)
    for known, opens in (
        ({"state": on, "alive": False}, True),
        ({"state": rest, "alive": False, "axes": moving(AxisId.X)}, True),
        ({"state": rest, "interrupted": True}, True),
        ({"state": rest, "alive": False}, False),
        # In service.
        ({"state": rest, "axes": moving(AxisId.X)}, False),
    ):
        assert (CardWatch().note(snapshot(**known)) is not None) is opens, known


def test_what_may_still_move_comes_first_whatever_else_is_known():
    hot = verbatim("hot").with_fault(Fault("later.laser_hot", may_move=True))
    outer = Fault("later.outer", COMPLETE.remedy)
    replaced = Message("{inner}", inner=MOVING).reporting_only(outer)
    for message in (hot, replaced, in_a_row([ASKED_STOP, FULL, MOVING])):
        for code in (SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED):
            assert fault_notice(said(code, message)).first == MAY_MOVE.remedy, message
        assert refusal_notice(Refused.START, message).first == MAY_MOVE.remedy, message
    notice = fault_notice(said(SurveyState.STOPPED, in_a_row([ASKED_STOP, FULL, MOVING])))
    assert not notice.resumable and notice.text == in_a_row([FULL, MOVING])


def walk(steps, watch=None):
    watch = watch or CardWatch()
    for number, (now, is_new) in enumerate(steps):
        card = watch.note(now if isinstance(now, Snapshot) else snapshot(state=now))
        assert (card is not None) is is_new, number
        assert card is None or isinstance(now, Snapshot) or card == fault_notice(now)
    return watch


def test_each_fault_opens_its_card_once():
    on = said(SurveyState.SURVEYING, verbatim("on"))
    fault, other = paused(FULL), paused(MOVING)
    again = said(SurveyState.PAUSED, warned(fault.message))
    watch = walk(((fault, True), (fault, False), (again, False), (other, True), (on, False)))
    assert watch.is_over
    walk(((other, True),), watch)
    # By their codes: a number that changes is no new one. Without a code, by their words.
    low, lower = (
        Message("{free} MB are free", free=free).with_fault(FULL.fault) for free in (7, 3)
    )
    walk(((paused(low), True), (paused(lower), False), (said(SurveyState.FAILED, lower), True)))
    one, another = paused(verbatim("no power")), paused(verbatim("no height"))
    walk(((one, True), (one, False), (another, True)))
    silent, heard = (snapshot(state=on, alive=alive) for alive in (False, True))
    walk(((silent, True), (silent, False), (heard, False), (silent, True)))
    # Again where the first step or the motion changes.
    warp = Fault("mast.warped", verbatim("Straighten."))
    changed = (warp, replace(warp, may_move=True), replace(warp, remedy=verbatim("Lower it.")))
    cards = [paused(verbatim("warped").with_fault(one)) for one in changed]
    walk((one, new) for one in cards for new in (True, False))


ACCEPTED = Answer(Request.STOP, True, verbatim("stopping"))
NOTHING = Answer(Request.STOP, False, verbatim("no survey is running"))
SILENT = Answer(Request.STOP, False, verbatim("nobody there"), contact=False)


class Robot:
    """What a screen hears of a robot, and a STOP that it follows."""

    def __init__(self):
        self.clock = FakeClock()
        self.stop = StopConfirmation(self.clock)
        self.shown = snapshot(SurveyState.SURVEYING, axes=())
        self.report(*AxisId)

    def report(self, *axes, moving=False):
        """Let axes report a moment later."""
        self.clock.advance(0.001)
        kept = [one for one in self.shown.axes if one.axis not in axes]
        new = [AxisReport(axis, 0.0, True, moving, "", self.clock.now_s()) for axis in axes]
        self.shown = replace(self.shown, axes=(*kept, *new))

    def press(self, *answering):
        """Press STOP; these axes answer at once."""
        self.stop.press()
        for axis in answering:
            self.stop.on_event(AxisStopAnswer(axis, True))

    def text(self):
        warning = self.stop.warning(self.shown)
        return "" if warning is None else str(warning)


AXES = st.sampled_from(AxisId)
STEPS = st.one_of(
    st.tuples(st.just("report"), AXES, st.booleans()),
    st.tuples(st.just("answer"), AXES, st.booleans()),
    st.tuples(st.just("control"), st.sampled_from([ACCEPTED, NOTHING, SILENT])),
    st.tuples(st.just("wait"), st.floats(0.0, 0.5)),
)


@settings(max_examples=draws(100))
@given(st.lists(STEPS, max_size=40))
def test_a_stop_is_open_until_every_axis_has_said_after_the_press_that_it_rests(steps):
    robot, pressed, heard = Robot(), {}, {}
    begun_s = answered_s = robot.clock.now_s()
    robot.press()
    for kind, *step in steps:
        if kind == "report":
            robot.report(step[0], moving=step[1])
            pressed[step[0]] = step[1]
        elif kind == "wait":
            robot.clock.advance(step[0])
        else:
            robot.stop.on_event(AxisStopAnswer(*step) if kind == "answer" else step[0])
            # Who has heard of the STOP delays it no more.
            who, has_heard = step if kind == "answer" else ("control", step[0] is not SILENT)
            answered_s = answered_s if heard.get(who) else robot.clock.now_s()
            heard[who] = has_heard
        text = robot.text()
        unproven = [axis for axis in AxisId if pressed.get(axis) is not False]
        if not robot.stop.is_open:
            # A slow main control may have begun a move before it answered.
            assert all(one.received_s > answered_s + EFFECT_S for one in robot.shown.axes)
            assert not unproven
            return
        assert unproven or not text
        if robot.clock.now_s() - begun_s > REST_S:
            for axis in AxisId:
                says_rest = f"{axis.value} axis: at rest" in text
                assert not unproven or says_rest is (axis not in unproven)


def test_what_moves_or_is_silent_is_named_before_any_limit_runs_out():
    robot = Robot()
    robot.press(*AxisId)
    robot.clock.advance(ANSWER_S)
    robot.report(*AxisId, moving=True)
    assert not robot.text(), "they slow down"
    robot.clock.advance(REST_S)
    assert "x axis: MOVES" in robot.text()
    robot = Robot()
    robot.press(AxisId.X, AxisId.Y)
    robot.stop.on_event(ACCEPTED)
    robot.clock.advance(ANSWER_S)
    robot.report(AxisId.X)
    robot.report(AxisId.Y, moving=True)
    assert "z axis: no answer yet" in robot.text()
    robot.stop.on_event(AxisStopAnswer(AxisId.Z, False))
    expected = "x axis: at rest; y axis: MOVES; z axis does NOT answer; main control: stopping"
    assert robot.text() == expected
    # One that was silent before the press is said at the press; the operator may close it.
    robot.shown = snapshot(axes=())
    for _ in range(2):
        robot.stop.close()
        assert not robot.text()
        robot.press()
        # Other answers confirm no stop.
        robot.stop.on_event(Answer(Request.PAUSE, True, verbatim("pausing")))
        assert "x axis: no answer yet" in robot.text()


def test_a_move_that_a_slow_main_control_began_after_the_stop_is_said():
    robot = Robot()
    robot.press(*AxisId)
    robot.report(*AxisId)
    robot.clock.advance(REST_S)
    assert not robot.text()
    robot.report(AxisId.X, moving=True)
    assert "x axis: MOVES" in robot.text()
    robot.report(*AxisId)
    robot.stop.on_event(ACCEPTED)
    # After another press the main control answers again; the axes have heard of the STOP.
    robot.press()
    robot.clock.advance(EFFECT_S)
    robot.report(*AxisId)
    assert not robot.text() and robot.stop.is_open, "it may move again"
    robot.stop.on_event(ACCEPTED)
    robot.clock.advance(EFFECT_S)
    robot.stop.on_event(AxisStopAnswer(AxisId.X, True))
    robot.report(*AxisId)
    assert not robot.text() and robot.stop.outcome is None
    robot.report(AxisId.X, moving=True)
    assert not robot.text(), "the STOP is over"


def test_the_answers_are_shown_where_no_survey_was_stopped():
    for answer, words in ((NOTHING, ": no survey is running"), (SILENT, " does NOT answer")):
        robot = Robot()
        robot.press(*AxisId)
        robot.stop.on_event(answer)
        robot.clock.advance(EFFECT_S)
        robot.report(*AxisId)
        assert not robot.text()
        card = robot.stop.outcome
        assert str(card.title).startswith("Every axis rests.")
        assert f"z axis: at rest; main control{words}" in str(card.text)
        assert (card.then is not None) is (answer is SILENT)
