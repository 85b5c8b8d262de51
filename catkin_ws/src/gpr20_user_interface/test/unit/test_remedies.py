"""Every fault that the robot can report says what to do first."""

import pytest
from fault_templates import fault_templates, filled

from gpr20_common.message import Message, in_a_row, verbatim
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid import remedies
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.fault_messages import FaultWatch, is_fault
from gpr20_user_interface.mid.notices import fault_notice
from gpr20_user_interface.mid.remedies import find_remedy

PAUSED = "Paused: {reason}. Fix the fault and resume, or stop."


def state(code, message):
    return ControlState(code, message, "id", True)


def paused(reason):
    return state(SurveyState.PAUSED, Message(PAUSED, reason=reason))


def test_the_sources_are_found():
    assert len(fault_templates()) > 180


@pytest.mark.parametrize("template", fault_templates())
def test_every_fault_has_a_card_that_says_what_to_do_first(template):
    reason = filled(template)
    assert find_remedy(reason) is not None
    notice = fault_notice(paused(reason))
    assert notice.text == reason and notice.first == find_remedy(reason)
    assert notice.resumable and notice.then is not None


@pytest.mark.parametrize(
    ("template", "remedy"),
    [
        ("the VNA's data are incomplete: {received} of {announced} bytes arrived", "CHECK_VNA"),
        ("no connection to the VNA at {address} ({reason})", "CHECK_VNA_CABLE"),
        ("the VNA's settings were changed during the sweep: {settings}", "HANDS_OFF_VNA"),
        ("the VNA is not calibrated; calibrate it before you continue", "CALIBRATE"),
        ("the {axis} axis did not reach {target:g} {unit}: {reason}", "CHECK_MOTORS"),
        ("the endstop was not reached within {distance:g} {unit}", "CHECK_ENDSTOP"),
        ("the height sensor's converter does not answer; check its wiring", "CHECK_HEIGHT"),
        ("{device} did not answer; check that it runs", "WAIT_FOR_PART"),
        ("{node} stopped answering", "WAIT_FOR_PART"),
        ("the disk is full", "MAKE_SPACE"),
        ("the disk is read-only", "CHECK_DISK"),
        ("internal error in the main control", "RESTART_ROBOT"),
    ],
)
def test_the_remedy_fits_the_fault(template, remedy):
    assert find_remedy(filled(template)) == getattr(remedies, remedy)


def test_the_inner_sentence_decides():
    reason = Message(
        "trace {index} could not be stored: {reason}", index=7, reason=Message("the disk is full")
    )
    assert find_remedy(reason) == remedies.MAKE_SPACE
    device = Message("{device} did not answer; check that it runs", device=Message("the VNA"))
    assert find_remedy(device) == remedies.WAIT_FOR_PART


def test_a_text_without_a_template_is_searched_itself():
    assert find_remedy(verbatim("the disk is full")) == remedies.MAKE_SPACE
    assert find_remedy(verbatim("something never seen")) is None
    assert fault_notice(paused(verbatim("never seen"))).first == remedies.CHECK_STATUS


def test_an_axis_that_moves_comes_before_everything():
    moving = Message("AN AXIS IS STILL MOVING: switch the motors off")
    message = in_a_row([Message("Stopped on request"), moving])
    assert is_fault(state(SurveyState.STOPPED, message))
    notice = fault_notice(state(SurveyState.STOPPED, message))
    assert notice.first == remedies.MOTORS_OFF and not notice.resumable


def test_a_pause_or_stop_on_request_is_no_fault():
    on_request = Message("Paused on request. Resume the survey, or stop it.")
    assert not is_fault(state(SurveyState.PAUSED, on_request))
    warned = Message("Warning: {warning}. {status}", warning=verbatim("w"), status=on_request)
    assert not is_fault(state(SurveyState.PAUSED, warned))
    assert not is_fault(state(SurveyState.STOPPED, Message("Stopped on request")))
    assert not is_fault(state(SurveyState.SURVEYING, verbatim("the disk is full")))


def test_the_words_around_a_fault_are_left_out():
    reason = Message("the disk is full", details="errno 28")
    inner = Message(PAUSED, reason=reason)
    warned = Message("Warning: {warning}. {status}", warning=verbatim("clock"), status=inner)
    notice = fault_notice(state(SurveyState.PAUSED, warned))
    assert notice.text == reason and notice.details == ("errno 28",)


def test_each_fault_is_reported_once():
    watch = FaultWatch()
    fault = paused(Message("the disk is full"))
    assert watch.note(fault) == fault
    assert watch.note(fault) is None
    warned = Message("Warning: {warning}. {status}", warning=verbatim("w"), status=fault.message)
    assert watch.note(state(SurveyState.PAUSED, warned)) is None
    other = paused(Message("no answer in time"))
    assert watch.note(other) == other
    assert watch.note(state(SurveyState.SURVEYING, verbatim("on"))) is None
    assert watch.note(other) == other
