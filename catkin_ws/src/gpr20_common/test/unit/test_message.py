"""Sentences as templates with values, and the faults behind them: how they travel."""

import json
import pickle
from dataclasses import replace

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults
from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.errors import Gpr20Error, InvalidValueError, NodeGoneError
from gpr20_common.message import (
    CODE_FORMAT,
    MAX_CHARACTERS,
    MOTORS_OFF,
    UNKNOWN_CODE,
    Fault,
    Message,
    Severity,
    in_a_row,
    numeral,
    received_message,
    verbatim,
)

pytest.importorskip("gpr20_msgs.msg")

from gpr20_common.high.answers import message_fields, message_from
from gpr20_msgs.msg import Fault as FaultMessage
from gpr20_msgs.srv import CommandResponse

LOOK, PLUG = Message("Look at the display."), Message("Plug in the {what}.", what="cable")
OUTER, INNER = Fault("survey.paused", LOOK), Fault("vna.no_answer", PLUG)
UNKNOWN = Fault("vna.odd")

codes = st.from_regex(CODE_FORMAT, fullmatch=True).filter(str.isascii)
remedies_of_any_kind = st.none() | st.builds(verbatim, st.text(min_size=1, max_size=20))
any_fault = st.builds(
    Fault, codes, remedies_of_any_kind, st.sampled_from(Severity), *[st.booleans()] * 2
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


NOTE = Fault("robot.asked_for", LOOK, Severity.NOTE)
SILENT_NOTE = Fault("survey.stopped", severity=Severity.NOTE)
MOVING = Fault("axis.moving", LOOK, may_move=True, can_continue=False)
LOST = Fault("survey.lost", can_continue=False)
WEAK, MOVES = (
    Fault(code, LOOK, Severity.WARNING, may_move=moves)
    for code, moves in (("vna.doubtful", False), ("axis.moves", True))
)


@each_case(
    "message, cause",
    [
        # The innermost with a remedy.
        (around(around(reporting(INNER), OUTER)), INNER),
        (around(reporting(UNKNOWN), OUTER), OUTER),
        # Else the innermost.
        (around(reporting(UNKNOWN), Fault("survey.odd")), UNKNOWN),
        (around(reporting(None)), None),
        # One that a sentence reports in place of those inside.
        (around(reporting(INNER)).reporting_only(OUTER), OUTER),
        (around(around(in_a_row([reporting(INNER)])).reporting_only(UNKNOWN), OUTER), OUTER),
        # Of those beside each other what moves, then the gravest, and then the first.
        (in_a_row([reporting(OUTER), reporting(INNER)]), OUTER),
        (in_a_row([reporting(INNER), reporting(OUTER)]), INNER),
        (in_a_row([reporting(SILENT_NOTE), reporting(UNKNOWN)]), UNKNOWN),
        *(
            (in_a_row([reporting(one) for one in order]), replace(MOVES, severity=Severity.FAULT))
            for order in ((MOVES, INNER, WEAK, NOTE), (NOTE, WEAK, INNER, MOVES))
        ),
        # A note gives way to a remedy around it.
        (around(reporting(NOTE), INNER), INNER),
        # The rest is that of the gravest.
        (around(reporting(NOTE), UNKNOWN), replace(NOTE, severity=Severity.FAULT)),
        (around(reporting(INNER), LOST), replace(INNER, can_continue=False)),
    ],
)
def test_what_decides(message, cause):
    assert message.cause == cause
    assert message.fault_code == ("" if cause is None else cause.code)
    if cause is not None:
        assert (message.severity, message.remedy) == (cause.severity, cause.remedy)
        assert (message.may_move, message.can_continue) == (cause.may_move, cause.can_continue)


def test_what_moves_still_moves_whatever_is_said_around_it():
    message = around(around(in_a_row([reporting(MOVING)]))).reporting_only(OUTER)
    assert (message.fault_code, message.may_move) == (OUTER.code, True)
    message = around(in_a_row([reporting(INNER), reporting(MOVING)]), OUTER)
    assert message.may_move and not around(reporting(None)).may_move


def test_the_power_comes_first_where_something_may_move_and_the_remedy_is_for_something_else():
    hot = Fault("later.hot", may_move=True)
    for message in (
        reporting(hot),
        around(reporting(INNER), hot),
        around(reporting(MOVING)).reporting_only(OUTER),
    ):
        assert message.remedy == MOTORS_OFF, message
    assert around(reporting(MOVING), OUTER).remedy == LOOK
    assert around(reporting(INNER), MOVING).remedy == LOOK


def test_a_warning_keeps_code_remedy_and_motion_of_the_cause():
    warning = around(reporting(MOVING), OUTER).as_warning()
    assert warning.cause == Fault("axis.moving", LOOK, Severity.WARNING, may_move=True)
    assert warning.may_move and warning == around(reporting(MOVING))
    assert reporting(None).as_warning().cause is None


# How it travels.


def answer(message):
    return CommandResponse(**message_fields(message))


@given(any_message)
def test_a_message_keeps_what_it_reports_on_the_graph_and_in_a_file(message):
    for back in (message_from(answer(message)), received_message(str(message), message.record())):
        assert (str(back), back.cause) == (str(message), message.cause)
        if len(message.to_json()) <= MAX_CHARACTERS:
            assert (back, back.record()) == (message, json.loads(message.to_json()))
    sent = pickle.loads(pickle.dumps(message))  # noqa: S301
    assert sent == message and sent.faults == message.faults


def test_an_answer_has_all_for_clients_that_know_neither_code_nor_catalogue():
    sent = answer(around(reporting(MOVING), OUTER).with_details("errno 5"))
    fault = sent.fault
    assert sent.message == "paused: no answer (errno 5)"
    assert (fault.code, fault.severity) == ("axis.moving", "fault")
    assert (fault.may_move, fault.can_continue) == (True, False)
    assert (fault.sentence, fault.details) == ("paused: {reason}", "errno 5")
    assert json.loads(fault.values)["reason"]["sentence"] == "no answer"
    assert fault.remedy == fault.remedy_sentence == str(LOOK)
    # Of a success only the sentence.
    fault = answer(Message("done")).fault
    assert (fault.sentence, fault.code, fault.severity, fault.remedy) == ("done", "", "", "")
    assert fault.can_continue and not fault.may_move


def test_an_answer_of_another_program_may_have_texts_alone():
    received = message_from(CommandResponse(message="stuck"))
    assert (received, received.cause) == (verbatim("stuck"), None)
    fault = FaultMessage(code="later.stuck", remedy="Pull {it}.", can_continue=True)
    received = message_from(CommandResponse(message="stuck {", fault=fault))
    assert str(received) == "stuck {"
    assert received.cause == Fault("later.stuck", verbatim("Pull {it}."))


def sent_with(fault, **more):
    return {"sentence": "no answer", "values": {}, **fault, **more}


@each_case("odd", ["critical", 0, None, {"level": "note"}])
def test_what_a_later_version_says_otherwise_counts_as_the_graver(odd):
    record = {"code": "vna.x", "severity": odd, "cost": [1], "may_move": odd, "can_continue": odd}
    message = received_message("", sent_with(record))
    assert message.fault == Fault("vna.x", may_move=True, can_continue=False)
    assert message.template == "no answer"


@each_case(
    "fault",
    [
        *({"code": odd} for odd in (3, None, "no code", {"x": 1})),
        {"code": "vna.x", "remedy_sentence": 7},
        {"code": "vna.x", "remedy": "Plug it in.", "remedy_sentence": "{x.__class__}"},
        {"code": "vna.x", "remedy_sentence": "{x.__class__}", "remedy_values": {"x": 1}},
        {"code": "vna.x", "remedy_sentence": "{x}", "remedy_values": {"x": "\udcff"}},
    ],
)
def test_a_damaged_fault_leaves_the_sentence_and_counts_as_grave(fault):
    message = received_message("as sent", sent_with(fault))
    assert message.template == "no answer"
    remedy = verbatim(fault["remedy"]) if "remedy" in fault else None
    assert (message.fault.severity, message.fault.remedy) == (Severity.FAULT, remedy)
    assert message.may_move and message.remedy == (remedy or MOTORS_OFF)
    assert message.fault_code == fault["code"] if fault["code"] == "vna.x" else UNKNOWN_CODE


@each_case("template", ["{place.real}", "{0}", "\ud800", "", 7])
def test_a_sentence_that_cannot_be_shown_keeps_its_fault(template):
    sent = {**reporting(MOVING).record(), "sentence": template, "values": {"place": 3}}
    message = received_message("as sent", sent)
    assert message == verbatim("as sent") and message.cause == MOVING


@each_case("unreadable", ["", "{", "null", "7", "[" * 5000])
def test_the_fault_counts_where_the_values_cannot_be_read(unreadable):
    sent = answer(Message("{x}", x=7).with_fault(MOVING))
    sent.fault.values = unreadable
    received = message_from(sent)
    assert received == verbatim("7") and received.cause == MOVING


@each_case(
    "text, sent",
    [
        ("x" * 1_000_000, {}),
        ("as sent", {"sentence": "{x}", "values": {"x": "a" * MAX_CHARACTERS}}),
        ("as sent", {"sentence": "{a}" * 3000, "values": {"a": "y" * 5000}}),
        ("y" * 1_000_000, {"sentence": "x" * 20_000, "values": {}}),
    ],
)
def test_a_text_that_no_window_could_show_is_cut_and_its_fault_is_kept(text, sent):
    message = received_message(text, {**sent, "code": "axis.moving", "may_move": True})
    assert len(str(message)) <= MAX_CHARACTERS + 1 and str(message)[:7] == text[:7]
    assert message.fault_code == "axis.moving" and message.may_move


def test_a_fault_without_a_code_keeps_its_remedy_and_that_something_may_move():
    for told in ({"may_move": True}, {"may_move": 1}, {"remedy": "Straighten."}):
        fault = received_message("", sent_with({"may_move": False, **told})).cause
        assert (fault.code, fault.may_move) == (UNKNOWN_CODE, "remedy" not in told)
        assert fault.remedy == (verbatim(told["remedy"]) if "remedy" in told else MOTORS_OFF)
    for told in ({}, {"may_move": False}, {"severity": "fault"}):
        assert received_message("", sent_with(told)).cause is None


KEYS = st.sampled_from(
    ["sentence", "values", "details", "code", "remedy", "remedy_sentence", "severity"]
)
hostile = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | codes,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(KEYS | st.text(), inner)
        | st.fixed_dictionaries({"code": codes | inner, "remedy": inner})
        | st.fixed_dictionaries({"sentence": st.text(), "values": st.just({}), "code": inner})
    ),
)


@given(hostile, st.text())
def test_whatever_arrives_as_a_message_can_be_shown_and_sent_again(record, text):
    for sent in (
        record,
        sent_with({"code": record}),
        sent_with({"code": "vna.x", "remedy": record, "remedy_sentence": record}),
        text,
    ):
        message = received_message(text, sent)
        assert str(message) == text or sent["sentence"] == message.template
        assert message.fault_code == "" or CODE_FORMAT.fullmatch(message.fault_code)
        str(message.remedy).encode()
        assert received_message(str(message), message.to_json()).cause == message.cause


# Errors.


class OwnError(InvalidValueError):
    fault = INNER


def test_an_error_has_the_fault_of_its_class_or_a_finer_one():
    assert OwnError(Message("x")).message.fault == INNER
    assert OwnError(Message("x"), fault=OUTER).message.fault == OUTER
    assert OwnError(reporting(UNKNOWN)).message.fault == UNKNOWN
    assert OwnError(reporting(UNKNOWN), fault=OUTER).message.fault == OUTER
    assert Gpr20Error(Message("x")).message.fault == faults.INTERNAL
    assert NodeGoneError(Message("x")).message.fault == faults.PART_SILENT


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


NUMBERS = st.one_of(st.integers(-(10**9), 10**9), st.floats())
FORMS = st.sampled_from(["", "g", ".12g", ".3g", ".0f", ".1f", "+.2f", "6.1f"])


@given(NUMBERS, NUMBERS, FORMS, FORMS)
def test_numbers_and_nothing_else_have_the_decimal_point_of_a_language(one, other, form, last):
    template = "of {address} v1.5: {one:" + form + "}, {other}"
    message = Message(template, one=one, other=numeral(other, last), address="192.168.1.10")
    english, spanish = message.sentence(), read_catalogue(Language.SPANISH).text(message)
    start = "of 192.168.1.10 v1.5: "
    assert english == f"{start}{one:{form}}, {other:{last}}"
    assert spanish == start + f"{one:{form}}".replace(".", ",") + ", " + (
        f"{other:{last}}".replace(".", ",")
    )
    assert str(received_message(english, message.to_json())) == english


def test_a_template_without_all_its_values_fails_where_it_is_written():
    with pytest.raises(KeyError, match="low_m"):
        Message("below {low_m:g} m")
    with pytest.raises(ValueError):
        Message("below {low_m:g} m", low_m="much")


def sent(template, **values):
    return {"sentence": template, "values": values}


def doubled(times):
    record = {"sentence": "a" * 100, "values": {}}
    for _ in range(times):
        record = {"sentence": "{x}{x}", "values": {"x": record}}
    return record


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
        '{"sentence": "x", "values": {}, "details": "\\ud800"}',
    ],
)
def test_a_message_that_cannot_be_shown_safely_leaves_the_text(received):
    assert received_message("as sent", received) == verbatim("as sent")


def test_what_people_are_shown_neither_hides_nor_controls():
    text = "a\u202eb\x1b[2J\0\n"
    shown = Catalogue().text(Message("{inner}", inner=in_a_row([verbatim(text)])))
    assert shown == "a\\u202eb\\x1b[2J\\x00\n" and str(verbatim(text)) == text


def test_text_that_looks_like_a_template_stays_as_it_is():
    assert str(verbatim("{x} {")) == "{x} {"
    assert str(Message("paused: {reason}", reason="{lost} and {0}")) == "paused: {lost} and {0}"
