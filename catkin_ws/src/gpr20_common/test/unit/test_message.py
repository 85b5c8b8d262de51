import json

import pytest
from case_kit import each_case

from gpr20_common.message import Fault, Message, Severity, in_a_row, verbatim
from gpr20_common.sent_message import received_message

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
