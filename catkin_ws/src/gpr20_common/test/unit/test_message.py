import json
import pickle

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.message import Fault, Message, Severity, in_a_row, verbatim
from gpr20_common.sent_message import received_message

SPANISH = {
    "the height {height_m:.3f} m is below {low_m:g} m": "la altura {height_m:.3f} m es menor de "
    "{low_m:g} m",
    "paused: {reason}": "en pausa: {reason}",
    "check the sensor": "compruebe el sensor",
    "{sentences}": "{sentences}",
}


def spanish(template):
    return SPANISH.get(template, template)


def low_height(details=""):
    return Message(
        "the height {height_m:.3f} m is below {low_m:g} m",
        height_m=0.0123,
        low_m=0.02,
        details=details,
    )


values = st.one_of(
    st.text(),
    st.integers(),
    st.floats(allow_nan=False),
    st.booleans(),
    st.builds(verbatim, st.text()),
)
messages = st.recursive(
    st.builds(
        lambda value, details: Message("is {a}", a=value, details=details), values, st.text()
    ),
    lambda inner: st.builds(
        lambda first, others: Message("{first} after {others}", first=first, others=tuple(others)),
        inner,
        st.lists(inner, max_size=3),
    ),
    max_leaves=6,
)


def test_a_message_reads_as_its_english_sentence():
    assert str(low_height()) == "the height 0.012 m is below 0.02 m"


def test_a_message_inside_a_message_is_translated_too():
    paused = Message(
        "paused: {reason}", reason=in_a_row([low_height(), Message("check the sensor")])
    )
    assert str(paused) == "paused: the height 0.012 m is below 0.02 m; check the sensor"
    assert paused.sentence(spanish) == (
        "en pausa: la altura 0.012 m es menor de 0.02 m; compruebe el sensor"
    )


def test_details_are_in_the_english_text_and_not_in_the_sentence():
    paused = Message("paused: {reason}", reason=low_height("[Errno 5]"), details="get_height")
    assert str(paused) == "paused: the height 0.012 m is below 0.02 m (get_height; [Errno 5])"
    assert paused.sentence() == "paused: the height 0.012 m is below 0.02 m"


def test_known_values_take_the_place_of_those_that_a_sentence_has_and_of_no_others():
    general = Message("restart {part} of {robot}", part="PART", robot="ROBOT")
    known = general.with_values({"part": "x_axis", "other": 1})
    assert str(known) == "restart x_axis of ROBOT"


def test_a_template_without_all_its_values_fails_where_it_is_written():
    with pytest.raises(KeyError, match="low_m"):
        Message("below {low_m:g} m")
    with pytest.raises(ValueError):
        Message("below {low_m:g} m", low_m="much")


@given(messages)
def test_a_message_comes_back_from_json_as_it_was(message):
    assert received_message("", message.to_json()) == message
    assert pickle.loads(pickle.dumps(message)) == message  # noqa: S301


@given(
    st.text(),
    st.one_of(
        st.text(),
        st.recursive(
            st.none() | st.integers() | st.text(),
            lambda inner: (
                st.lists(inner)
                | st.dictionaries(
                    st.sampled_from(["template", "values", "details"]) | st.text(), inner
                )
            ),
        ).map(json.dumps),
    ),
)
def test_whatever_arrives_can_be_shown(text, received):
    message = received_message(text, received)
    assert isinstance(message.sentence(spanish), str)
    assert str(message) == text or json.loads(received)["template"] == message.template


@each_case(
    "template",
    ["{x:>99999999999}", "{x.__class__}", "{x[0]}", "{x!r:>9999999}", "{0}", "{x:{x}}", "{x"],
)
def test_a_template_from_elsewhere_cannot_ask_for_more_than_its_values(template):
    received = json.dumps({"template": template, "values": {"x": 7, "0": 1}})
    assert received_message("as sent", received) == verbatim("as sent")


def test_messages_inside_messages_cannot_multiply_the_text():
    record = {"template": "a" * 100, "values": {}}
    for _ in range(30):
        record = {"template": "{x}{x}", "values": {"x": record}}
    assert received_message("as sent", json.dumps(record)) == verbatim("as sent")
    long = json.dumps({"template": "{x}" * 5000, "values": {"x": "a" * 20_000}})
    assert received_message("as sent", long) == verbatim("as sent")


@each_case("field", ["{x:g}", "{x:f}", "{x:%}"])
def test_a_received_number_too_large_for_its_format_leaves_the_text(field):
    record = {"template": f"height {field}", "values": {"x": 10**400}}
    assert received_message("as sent", json.dumps(record)) == verbatim("as sent")


@each_case(
    "record",
    [
        {"template": "\ud800", "values": {}},
        {"template": "{x}", "values": {"x": "\udcff"}},
        {"template": "x", "values": {}, "details": "\ud800"},
    ],
)
def test_a_received_message_that_cannot_be_sent_leaves_the_text(record):
    assert received_message("as sent", json.dumps(record)) == verbatim("as sent")


def test_a_received_message_nested_too_deeply_to_be_shown_leaves_the_text():
    message = Message("x")
    for _ in range(200):
        message = Message("{x}", x=message)
    assert received_message("as sent", message.to_json()) == verbatim("as sent")


def test_text_that_looks_like_a_template_stays_as_it_is():
    assert str(verbatim("{x} {")) == "{x} {"
    assert str(Message("paused: {reason}", reason="{lost} and {0}")) == "paused: {lost} and {0}"


def test_other_values_become_numbers_or_text():
    numpy = pytest.importorskip("numpy")
    message = Message(
        "{a:.1f} {b:d} {c}", a=numpy.float32(2.5), b=numpy.int64(3), c=InvalidValueError
    )
    assert str(message).startswith("2.5 3 <class")
    assert received_message("", message.to_json()) == message
    assert str(Message("{a} m", a=numpy.array([1.0, 2.0]))) == "[1. 2.] m"
    assert str(Message("{a} m", a=numpy.array([]))) == "[] m"


def test_an_error_carries_its_message():
    error = Gpr20Error(low_height("[Errno 5]"))
    assert error.message == low_height("[Errno 5]")
    assert str(error) == "the height 0.012 m is below 0.02 m ([Errno 5])"


FULL = Message("full").with_fault(Fault("disk.full", Message("make space"), can_continue=False))
ASKED = Message("asked for").with_fault(Fault("survey.asked", severity=Severity.NOTE))


def test_what_did_not_succeed_is_the_outermost_sentence_that_says_so():
    outer = Message("not stored: {reason}", reason=FULL).with_fault(Fault("trace.not_stored"))
    assert Message("paused: {reason}", reason=outer).failure == outer
    assert in_a_row([ASKED, FULL, outer]).failure == in_a_row([FULL, outer])
    assert Message("{text}, {asked}", text=verbatim("x"), asked=ASKED).failure is None
    assert Message("warning: {warning}", warning=outer.as_warning()).failure is None


def test_a_sentence_knows_the_remedy_of_its_cause_and_whether_the_survey_can_continue():
    paused = Message("paused: {reason}", reason=FULL)
    assert paused.remedy == Message("make space") and not paused.can_continue
    warning = paused.as_warning()
    assert warning.remedy == Message("make space") and warning.can_continue
    assert verbatim("x").remedy is None and ASKED.remedy is None and verbatim("x").can_continue
