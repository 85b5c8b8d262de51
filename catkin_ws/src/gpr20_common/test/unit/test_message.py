"""Sentences as templates with values, and the faults behind them: how they travel."""

import json
import pickle
from types import SimpleNamespace

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults
from gpr20_common.errors import Gpr20Error, InvalidValueError, NodeGoneError
from gpr20_common.message import (
    CODE_FORMAT,
    Fault,
    Message,
    Severity,
    in_a_row,
    verbatim,
)
from gpr20_common.sent_message import (
    MAX_CHARACTERS,
    message_fields,
    message_from,
    received_message,
)

LOOK, PLUG = Message("Look at the display."), Message("Plug in the {what}.", what="cable")
OUTER, INNER = Fault("survey.paused", LOOK), Fault("vna.no_link", PLUG)
UNKNOWN = Fault("vna.odd")

codes = st.from_regex(CODE_FORMAT, fullmatch=True).filter(str.isascii)
remedies_of_any_kind = st.none() | st.builds(verbatim, st.text(max_size=20))
any_fault = st.builds(
    Fault, codes, remedies_of_any_kind, st.sampled_from(Severity), *[st.booleans()] * 3
)
values = st.text() | st.integers() | st.floats(allow_nan=False) | st.booleans()
any_message = st.recursive(
    st.builds(
        lambda value, details, fault: Message("is {a}", a=value, details=details).with_fault(fault),
        values | st.builds(verbatim, st.text()),
        st.text(),
        any_fault,
    ),
    lambda inner: st.builds(
        lambda parts, fault: in_a_row(parts).with_fault(fault),
        st.lists(inner, max_size=3),
        st.none() | any_fault,
    ),
    max_leaves=6,
)


def around(inner, fault=None):
    return Message("paused: {reason}", reason=inner).with_fault(fault)


def reporting(fault):
    return Message("no answer").with_fault(fault)


NOTE = Fault("axis.stopped", LOOK, Severity.NOTE)
SILENT_NOTE = Fault("survey.stopped", severity=Severity.NOTE)
MOVING = Fault("axis.moving", LOOK, may_move=True, can_continue=False)
COVER = Fault("axis.spi", replaces=True)
WEAK, MOVES = (
    Fault(code, LOOK, Severity.WARNING, may_move=moves)
    for code, moves in (("vna.weak", False), ("axis.moves", True))
)


@each_case(
    "message, cause",
    [
        # The innermost with a remedy.
        (around(around(reporting(INNER), OUTER)), INNER),
        (around(reporting(UNKNOWN), OUTER), OUTER),
        # One without is better than none, and the outer one names what failed.
        (around(reporting(UNKNOWN), Fault("survey.odd")), Fault("survey.odd")),
        (around(reporting(None)), None),
        # One that replaces those inside.
        (around(reporting(INNER), COVER), COVER),
        (around(around(reporting(INNER), COVER), OUTER), OUTER),
        # Of those beside each other the most urgent, and then the first.
        (in_a_row([reporting(OUTER), reporting(INNER)]), OUTER),
        (in_a_row([reporting(INNER), reporting(OUTER)]), INNER),
        (in_a_row([reporting(SILENT_NOTE), reporting(UNKNOWN)]), UNKNOWN),
        *(
            (in_a_row([reporting(one) for one in order]), MOVES)
            for order in ((MOVES, INNER, WEAK, NOTE), (NOTE, WEAK, INNER, MOVES))
        ),
        # A note never over a graver one around it.
        (around(reporting(NOTE), INNER), INNER),
        (around(reporting(NOTE), UNKNOWN), NOTE),
    ],
)
def test_what_decides(message, cause):
    assert message.cause == cause
    assert message.fault_code == ("" if cause is None else cause.code)
    assert cause is None or cause in message.faults


def test_what_moves_still_moves_whatever_is_said_around_it():
    cover = Fault("axis.spi", LOOK, replaces=True)
    message = around(around(reporting(MOVING), cover), OUTER)
    assert (message.cause, message.faults, message.may_move) == (cover, (OUTER, cover), True)
    message = around(in_a_row([reporting(INNER), reporting(MOVING)]), OUTER)
    assert message.may_move and not around(reporting(None)).may_move


def test_a_warning_keeps_code_remedy_and_motion_of_the_cause():
    warning = around(reporting(MOVING), OUTER).as_warning()
    assert warning.cause == Fault(
        "axis.moving", LOOK, Severity.WARNING, may_move=True, replaces=True
    )
    assert warning.may_move and warning == around(reporting(MOVING))
    assert reporting(None).as_warning().cause is None


@each_case("code", ["", "vna.", "Vna.x", "vna.x\n", "a.b.c", "a" * 31 + ".b"])
def test_a_code_has_the_form_area_what(code):
    with pytest.raises(ValueError):
        Fault(code)


# How it travels.


@given(any_message)
def test_a_message_keeps_its_faults_on_the_graph_and_in_a_file(message):
    fields = message_fields(message)
    assert fields["fault_code"] == message.fault_code
    back = message_from(SimpleNamespace(**fields))
    assert str(back) == str(message) and back.fault_code == message.fault_code
    if len(message.to_json()) <= MAX_CHARACTERS:
        assert received_message("", message.to_json()) == message
        assert json.loads(back.to_json()) == json.loads(message.to_json())
        assert (back.cause, back.faults) == (message.cause, message.faults)
    sent = pickle.loads(pickle.dumps(message))  # noqa: S301
    assert sent == message and sent.faults == message.faults


def sent_with(fault, **more):
    return json.dumps({"template": "no answer", "values": {}, "fault": fault, **more})


@each_case("severity", ["critical", None, {"level": "note"}])
def test_keys_and_values_of_a_later_version_count_as_usual_and_a_severity_as_a_fault(severity):
    record = {"code": "vna.x", "severity": severity, "cost": [1]}
    message = received_message("", sent_with(record))
    assert message.fault == Fault("vna.x") and message.template == "no answer"


@each_case("odd", ["false", 0, None])
def test_a_flag_that_is_neither_true_nor_false_counts_as_the_graver_one(odd):
    record = {"code": "vna.x", "may_move": odd, "can_continue": odd, "replaces": odd}
    fault = received_message("", sent_with(record)).fault
    assert (fault.may_move, fault.can_continue, fault.replaces) == (True, False, False)


@each_case(
    "fault",
    [
        *(None, "vna.x", {}, {"code": 3}, {"code": "no code"}),
        *({"code": "vna.x", "remedy": odd} for odd in (None, {"values": {}})),
        {"code": "vna.x", "remedy": {"template": "{x.__class__}", "values": {"x": 1}}},
        {"code": "vna.x", "remedy": {"template": "{x}", "values": {"x": "\udcff"}}},
    ],
)
def test_a_damaged_fault_leaves_the_sentence_and_counts_as_grave(fault):
    message = received_message("as sent", sent_with(fault), "vna.no_link")
    assert message.template in ("no answer", "{text}")
    assert message.cause.severity is Severity.FAULT and message.cause.remedy is None
    assert message.fault_code in ("vna.x", "vna.no_link")


@each_case("template", ["{place.real}", "{0}", "\ud800"])
def test_a_sentence_that_cannot_be_shown_keeps_its_fault(template):
    inner = json.loads(reporting(MOVING).to_json())
    text = json.dumps({"template": template, "values": {"place": 3, "reason": inner}})
    message = received_message("as sent", text, "axis.moving")
    assert message == verbatim("as sent") and message.remedy == LOOK
    assert message.may_move and not message.can_continue and message.fault_code == "axis.moving"


@each_case("unreadable", ["", "{", "null", "7", "[" * 5000])
def test_the_code_counts_where_the_json_cannot_be_read(unreadable):
    message = received_message("as sent", unreadable, "axis.lost_zero")
    assert str(message) == "as sent" and message.cause == Fault("axis.lost_zero")


def test_a_huge_message_leaves_the_text_and_the_fault():
    huge = Message("{x}", x="a" * MAX_CHARACTERS).with_fault(MOVING)
    message = message_from(SimpleNamespace(**message_fields(huge)))
    assert message == verbatim(str(huge)) and message.may_move
    assert (message.fault_code, message.remedy) == (MOVING.code, LOOK)


@each_case(
    "text, sent",
    [
        ("x" * 1_000_000, ""),
        ("as sent", json.dumps({"template": "{a}" * 3000, "values": {"a": "y" * 5000}})),
        ("y" * 1_000_000, json.dumps({"template": "x" * 20_000, "values": {}})),
    ],
)
def test_a_text_that_no_window_could_show_is_cut_and_its_fault_is_kept(text, sent):
    record = {**json.loads(sent or "{}"), "fault": {"code": "axis.moving", "may_move": True}}
    message = received_message(text, json.dumps(record) if sent else "", "axis.moving")
    assert len(str(message)) <= MAX_CHARACTERS + 1 and str(message)[:7] == text[:7]
    assert message.fault_code == "axis.moving" and message.may_move == bool(sent)


KEYS = st.sampled_from(["template", "values", "details", "fault", "code", "remedy", "severity"])
hostile = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | codes,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(KEYS | st.text(), inner)
        | st.fixed_dictionaries({"code": codes | inner, "remedy": inner})
        | st.fixed_dictionaries({"template": st.text(), "values": st.just({}), "fault": inner})
    ),
)


@given(hostile, st.text(), codes | st.text())
def test_whatever_arrives_as_a_fault_can_be_shown_and_sent_again(record, text, code):
    for sent in (sent_with(record), json.dumps(record), text):
        message = received_message(text, sent, code)
        assert str(message) == text or json.loads(sent)["template"] == message.template
        assert message.fault_code == "" or CODE_FORMAT.fullmatch(message.fault_code)
        if message.cause is not None and message.cause.remedy is not None:
            str(message.cause.remedy).encode()
        again = message_from(SimpleNamespace(**message_fields(message)))
        assert again.fault_code == message.fault_code


# Errors.


class OwnError(InvalidValueError):
    fault = INNER


def test_an_error_has_the_fault_of_its_class_or_a_finer_one():
    assert OwnError(Message("x")).message.fault == INNER
    assert OwnError(Message("x"), fault=OUTER).message.fault == OUTER
    assert OwnError(reporting(UNKNOWN)).message.fault == UNKNOWN
    assert OwnError(reporting(UNKNOWN), fault=OUTER).message.fault == OUTER
    assert Gpr20Error(Message("x")).message.fault == faults.INTERNAL
    assert NodeGoneError(Message("x")).message.fault == faults.NODE_GONE


# Sentences.


SPANISH = {
    "the height {height_m:.3f} m is below {low_m:g} m": "altura {height_m:.3f} m, mínima {low_m:g}",
    "paused: {reason}": "en pausa: {reason}",
    "check the sensor": "compruebe el sensor",
}


def spanish(template):
    return SPANISH.get(template, template)


def low_height(details=""):
    template = "the height {height_m:.3f} m is below {low_m:g} m"
    return Message(template, height_m=0.0123, low_m=0.02, details=details)


def test_a_message_and_those_in_it_are_one_sentence_in_every_language_beside_the_details():
    reason = in_a_row([low_height("[Errno 5]"), Message("check the sensor")])
    paused = Message("paused: {reason}", reason=reason, details="get_height")
    sentence = "paused: the height 0.012 m is below 0.02 m; check the sensor"
    assert paused.sentence() == sentence
    assert str(paused) == f"{sentence} (get_height; [Errno 5])"
    assert paused.sentence(spanish) == "en pausa: altura 0.012 m, mínima 0.02; compruebe el sensor"


def test_a_template_without_all_its_values_fails_where_it_is_written():
    with pytest.raises(KeyError, match="low_m"):
        Message("below {low_m:g} m")
    with pytest.raises(ValueError):
        Message("below {low_m:g} m", low_m="much")


def sent(template, **values):
    return json.dumps({"template": template, "values": values})


def doubled(times):
    record = {"template": "a" * 100, "values": {}}
    for _ in range(times):
        record = {"template": "{x}{x}", "values": {"x": record}}
    return json.dumps(record)


def nested(depth):
    message = Message("x")
    for _ in range(depth):
        message = Message("{x}", x=message)
    return message.to_json()


TEMPLATES = ["{x:>99999999999}", "{x.__class__}", "{x[0]}", "{x!r:>9999999}", "{x:{x}}", "{x"]


@each_case(
    "received",
    [
        # It asks for more than its values.
        *(sent(template, **{"x": 7, "0": 1}) for template in TEMPLATES),
        # The text would multiply, or a number is too large for its format.
        *(doubled(30), sent("{x}" * 5000, x="a" * 20_000)),
        *(sent(f"height {field}", x=10**400) for field in ("{x:g}", "{x:f}", "{x:%}")),
        # It cannot be sent again, or is nested too deeply to be shown.
        *(sent("\ud800"), sent("{x}", x="\udcff"), nested(200)),
        '{"template": "x", "values": {}, "details": "\\ud800"}',
    ],
)
def test_a_message_that_cannot_be_shown_safely_leaves_the_text(received):
    assert received_message("as sent", received) == verbatim("as sent")


def test_text_that_looks_like_a_template_stays_as_it_is():
    assert str(verbatim("{x} {")) == "{x} {"
    assert str(Message("paused: {reason}", reason="{lost} and {0}")) == "paused: {lost} and {0}"


FULL = Message("full").with_fault(Fault("disk.full", Message("make space"), can_continue=False))
ASKED = Message("asked for").with_fault(Fault("survey.asked", severity=Severity.NOTE))


def test_what_did_not_succeed_is_the_outermost_sentence_that_says_so():
    outer = Message("not stored: {reason}", reason=FULL).with_fault(Fault("trace.not_stored"))
    assert Message("paused: {reason}", reason=outer).failure == outer
    assert in_a_row([ASKED, FULL, outer]).failure == in_a_row([FULL, outer])
    assert Message("{text}, {asked}", text=verbatim("x"), asked=ASKED).failure is None
    assert Message("warning: {warning}", warning=outer.as_warning()).failure is None
