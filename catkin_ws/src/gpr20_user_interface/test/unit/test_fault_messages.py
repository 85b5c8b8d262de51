"""Card, band and STOP follow the faults of a status, whatever its words and its version."""

import json

import pytest

pytest.importorskip("gpr20_msgs.msg")

from view_kit import moving, snapshot

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity, in_a_row, verbatim
from gpr20_common.sent_message import message_fields, message_from
from gpr20_msgs.msg import ControlStatus
from gpr20_msgs.srv import CommandResponse
from gpr20_operator.high.conversions import control_state
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.notices import (
    CardWatch,
    Refused,
    band_notice,
    fault_notice,
    refusal_notice,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import ENDED, SurveyState

PAUSED = "Paused: {reason}. Fix the fault and resume, or stop."
FULL = Message("the disk is full", details="errno 28").with_fault(
    Fault("disk.full", remedies.MAKE_SPACE)
)
MOVING = Message("a motor runs").with_fault(
    Fault("axis.still_moving", remedies.MOTORS_OFF, may_move=True)
)
ASKED_PAUSE = Message("asked for").with_fault(
    Fault("survey.paused_on_request", severity=Severity.NOTE)
)
ASKED_STOP = Message("asked for").with_fault(
    Fault("survey.stopped_on_request", severity=Severity.NOTE)
)
LOST = Message("lost").with_fault(Fault("survey.lost", remedies.NEW_SURVEY, can_continue=False))
CLOCK = Message("the clock is late").with_fault(Fault("clock.late", remedies.SET_CLOCK))


def state(code, message):
    return ControlState(code, message, "id", True)


def paused(reason):
    return state(SurveyState.PAUSED, Message(PAUSED, reason=reason))


def warned(status):
    return Message("Warning: {warning}. {status}", warning=CLOCK.as_warning(), status=status)


def test_what_is_reported_while_a_survey_runs_is_no_card():
    for code in set(SurveyState) - {SurveyState.PAUSED, *ENDED}:
        assert not state(code, FULL).is_fault, code


def test_a_pause_or_an_end_is_a_fault_unless_it_was_asked_for():
    for code, message, fault in (
        (SurveyState.FAILED, verbatim("x"), True),
        (SurveyState.FAILED, ASKED_STOP, True),
        (SurveyState.PAUSED, Message(PAUSED, reason=FULL), True),
        (SurveyState.PAUSED, ASKED_PAUSE, False),
        (SurveyState.PAUSED, warned(ASKED_PAUSE), False),
        (SurveyState.PAUSED, Message("{a}, but {b}", a=ASKED_PAUSE, b=FULL), True),
        (SurveyState.PAUSED, verbatim("Paused on request."), True),
        (SurveyState.PAUSED, warned(verbatim("x")), True),
        (SurveyState.STOPPED, ASKED_STOP, False),
        (SurveyState.STOPPED, verbatim("x"), False),
        (SurveyState.STOPPED, in_a_row([ASKED_STOP, FULL]), True),
        (SurveyState.FINISHED, warned(verbatim("x")), False),
    ):
        assert state(code, message).is_fault is fault, (code, message)


def test_a_stop_is_confirmed_only_by_a_status_that_says_so():
    for code, message, may_move in (
        (SurveyState.STOPPED, in_a_row([ASKED_STOP, MOVING]), True),
        (SurveyState.STOPPED, in_a_row([ASKED_STOP, FULL]), False),
        (SurveyState.STOPPED, ASKED_STOP, False),
        # Nobody says that all is at rest.
        (SurveyState.STOPPED, verbatim("Stopped on request"), True),
        (SurveyState.STOPPED, verbatim("x").with_fault(Fault("later.code")), True),
        (SurveyState.FAILED, FULL, True),
        (SurveyState.FINISHED, verbatim("x"), False),
    ):
        assert state(code, message).axis_may_move is may_move, (code, message)


def test_an_axis_that_moves_comes_before_everything():
    notice = fault_notice(state(SurveyState.STOPPED, in_a_row([ASKED_STOP, FULL, MOVING])))
    assert notice.first == remedies.MOTORS_OFF and not notice.resumable
    assert notice.text == in_a_row([FULL, MOVING])


def test_an_axis_that_moves_comes_first_whatever_else_is_known():
    hot = verbatim("hot").with_fault(Fault("later.laser_hot", may_move=True))
    outer = Fault("later.outer", remedies.NEW_SURVEY, replaces=True)
    replaced = Message("{inner}", inner=MOVING).with_fault(outer)
    for message in (hot, in_a_row([hot, FULL]), replaced):
        for code in (SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED):
            assert fault_notice(state(code, message)).first == remedies.MOTORS_OFF, message
        assert refusal_notice(Refused.START, message).first == remedies.MOTORS_OFF, message


def test_a_fault_that_moves_something_and_knows_what_to_do_keeps_its_remedy():
    fault = Fault("later.move", remedies.CHECK_ENDSTOP, may_move=True)
    assert remedies.first_step(verbatim("x").with_fault(fault)) == remedies.CHECK_ENDSTOP


def test_the_words_around_a_fault_are_left_out():
    notice = fault_notice(state(SurveyState.PAUSED, warned(Message(PAUSED, reason=FULL))))
    assert notice.text == FULL and notice.first == remedies.MAKE_SPACE
    assert notice.details == ("disk.full", "errno 28")
    assert notice.resumable and notice.then is not None


def test_the_innermost_remedy_counts_and_the_outermost_sentence_is_shown():
    outer = Message("trace 7 is not stored: {reason}", reason=FULL).with_fault(
        Fault("storage.not_stored", remedies.CHECK_DISK)
    )
    notice = fault_notice(paused(outer))
    assert notice.text == outer and notice.first == remedies.MAKE_SPACE


def test_resume_is_not_offered_for_a_survey_that_cannot_continue():
    for code in (SurveyState.PAUSED, SurveyState.FAILED):
        notice = fault_notice(state(code, Message(PAUSED, reason=LOST)))
        assert not notice.resumable
        assert notice.then != fault_notice(state(code, FULL)).then
    notice = refusal_notice(Refused.RESUME, Message("{reason}", reason=LOST))
    assert notice.first == remedies.NEW_SURVEY and notice.then is None
    assert refusal_notice(Refused.RESUME, FULL).then is not None
    assert refusal_notice(Refused.START, LOST).then is not None


def test_what_a_survey_warns_of_is_shown_with_its_remedy():
    for message, remedy in (
        (warned(verbatim("x")), remedies.SET_CLOCK),
        (Message("{reason} ...", reason=FULL), remedies.MAKE_SPACE),
    ):
        now = snapshot(state=state(SurveyState.SURVEYING, message))
        assert condition_of(now).level is JobLevel.ATTENTION
        assert band_notice(now).first == remedy


def watched(watch, state, **known):
    return watch.note(snapshot(state=state, **known))


def test_each_fault_opens_its_card_once():
    watch = CardWatch()
    fault, other = paused(FULL), paused(MOVING)
    same_words = paused(MOVING.with_fault(Fault("axis.stuck", remedies.HOME_AXIS)))
    on = state(SurveyState.SURVEYING, verbatim("on"))
    again = state(SurveyState.PAUSED, warned(fault.message))
    for now, is_new in (
        *((fault, True), (fault, False), (again, False), (other, True), (same_words, True)),
        *((other, True), (on, False), (other, True)),
    ):
        card = watched(watch, now)
        assert (card is not None) is is_new, now
        assert watch.is_over is (now is on)
        assert card is None or card == fault_notice(now)


def test_a_number_that_changes_is_no_new_fault():
    watch = CardWatch()
    low, lower = (
        Message("{free_mb} MB are free", free_mb=free_mb).with_fault(FULL.fault)
        for free_mb in (7, 3)
    )
    for now, is_new in (
        *((paused(low), True), (paused(lower), False)),
        *((state(SurveyState.FAILED, lower), True), (state(SurveyState.CHECKING, lower), False)),
        (paused(lower), True),
    ):
        assert (watched(watch, now) is not None) is is_new, now
    on = state(SurveyState.SURVEYING, verbatim("on"))
    for silent_s, is_new in ((6.0, True), (7.0, False), (0.1, False), (6.0, True)):
        card = watched(watch, on, alive=silent_s < 5.0, control_silent_s=silent_s)
        assert (card is not None) is is_new, silent_s


def test_words_without_a_code_are_told_apart_by_the_words():
    watch = CardWatch()
    one, other = paused(verbatim("no power")), paused(verbatim("no height"))
    assert watched(watch, one) is not None
    assert watched(watch, one) is None
    assert watched(watch, other) is not None


def test_a_lost_contact_opens_a_card_only_where_something_may_move():
    on, rest = state(SurveyState.SURVEYING, ASKED_PAUSE), state(SurveyState.IDLE, ASKED_STOP)
    for known, opens in (
        ({"state": on, "alive": False}, True),
        ({"state": rest, "alive": False, "axes": moving(AxisId.X)}, True),
        ({"state": rest, "interrupted": True}, True),
        ({"state": rest, "alive": False}, False),
        # In service.
        ({"state": rest, "axes": moving(AxisId.X)}, False),
    ):
        assert (CardWatch().note(snapshot(**known)) is not None) is opens, known


# What a later version may send: a sentence, a code, a severity and a remedy that are not known.
LATER = {
    "template": "the {thing} is warped",
    "values": {"thing": "mast"},
    "fault": {
        "code": "mast.warped",
        "severity": "disaster",
        "remedy": {"template": "Straighten the {thing}.", "values": {"thing": "mast"}},
    },
}


def received(code, fault=None, **fields):
    """Return a status whose reason was sent by another version."""
    reason = {**LATER, "fault": {**LATER["fault"], **(fault or {})}}
    sent = {
        "message": "Paused: the mast is warped.",
        "message_json": json.dumps(
            {"template": "Held: {reason}.", "values": {"reason": reason}, "new key": 1}
        ),
        "fault_code": "mast.warped",
        **fields,
    }
    return control_state(ControlStatus(code=int(code), survey_id="id", **sent))


def test_a_fault_that_this_version_does_not_know_has_the_remedy_that_travelled_with_it():
    now = received(SurveyState.PAUSED)
    notice = fault_notice(now)
    assert now.is_fault and notice.resumable
    assert str(notice.text) == "the mast is warped"
    assert str(notice.first) == "Straighten the mast."
    assert "mast.warped" in notice.details


def test_what_an_unknown_fault_allows_is_known():
    for one in (True, False):
        assert fault_notice(received(SurveyState.PAUSED, {"can_continue": one})).resumable is one
        assert received(SurveyState.STOPPED, {"may_move": one}).axis_may_move is one


def test_a_code_without_a_readable_message_is_a_fault_with_its_text():
    for message_json in ("", "{", "[]", "x" * 20_000, '{"template": 1}'):
        now = received(SurveyState.PAUSED, message_json=message_json)
        notice = fault_notice(now)
        assert now.is_fault and notice.resumable, message_json
        assert str(notice.text) == "Paused: the mast is warped."
        assert notice.first == remedies.CHECK_STATUS
        assert "mast.warped" in notice.details
        ended = received(SurveyState.STOPPED, message_json=message_json)
        assert ended.is_fault and ended.axis_may_move, message_json


def test_a_status_of_a_version_without_faults_is_a_fault_with_its_text():
    before = json.dumps({"template": PAUSED, "values": {"reason": "the disk is full"}})
    now = received(SurveyState.PAUSED, message_json=before, fault_code="")
    notice = fault_notice(now)
    assert now.is_fault and notice.resumable
    assert "the disk is full" in str(notice.text)
    assert notice.first == remedies.CHECK_STATUS
    assert received(SurveyState.STOPPED, message_json=before, fault_code="").axis_may_move


def test_a_refusal_of_another_version_is_shown_with_its_text():
    for fault_code in ("", "mast.warped", "no code"):
        fields = {**message_fields(verbatim("warped")), "fault_code": fault_code}
        reason = message_from(CommandResponse(success=False, **fields))
        notice = refusal_notice(Refused.START, reason)
        assert str(notice.text) == "warped" and notice.first == remedies.CHECK_STATUS
        assert notice.details == ((fault_code,) if "." in fault_code else ())
