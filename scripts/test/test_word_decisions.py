"""The lint finds programs that decide by words."""

import random
from pathlib import Path

import pytest
from word_decisions import complaints

SOURCES = Path(__file__).resolve().parents[2] / "catkin_ws/src"

DECISIONS = [
    "message == CONTROL_SILENT",
    "CONTROL_SILENT != answer.message",
    "one.template.startswith(STILL_MOVING)",
    "state.message.sentence().startswith('Warning: ')",
    "message.template == other",
    "'disk is full' in str(error)",
    "str(caught.message) == verdict",
    "re.search('calibrat', message.sentence())",
    "PATTERN.match(failure)",
    "verdict.startswith('complete')",
    "status.message in ('not homed', 'moving')",
    "node.values['homed'] == 'True'",
    "node.values.get('endstop') in ('pressed', 'open')",
    "REMEDIES[error.message.template]",
    "reason == Message('the disk is full')",
    "error.strerror == 'No space left on device'",
    "status.message.lower() == 'ok'",
    "answer.message[:4] == 'STOP'",
    "message.sentence()[:4] == 'STOP'",
    "f'{error}' == 'busy'",
    "error.args[0] == 'busy'",
    "ADVICE[reason]",
    "ADVICE.get(message)",
    "KNOWN.issuperset([one.template])",
    "'not_calibrated' in answer.message_json",
    "dict(health.values)['homed'] == 'True'",
    "{'busy': 1}.get(answer.message)",
    "'moving' in f'{message}!'",
    "operator.contains(str(error), 'busy')",
    "str(error).__contains__('busy')",
]
NO_DECISIONS = [
    "message.fault_code == faults.DISK_FULL.code",
    "message.cause is None",
    "failures[-2].message != failure.message",
    "message != ''",
    "answer.message or verbatim(text)",
    "state.code is SurveyState.PAUSED",
    "name.startswith('traces/')",
    "record['format'] == FORMAT",
    "print(message.sentence())",
    "message.values.get('stored')",
    "f'{error}: {path}'",
]


@pytest.mark.parametrize("decision", DECISIONS)
def test_a_decision_by_words_is_found_wherever_it_stands(decision):
    files = sorted(SOURCES.glob("gpr20_*/src/**/*.py"))
    for path in random.Random(decision).sample(files, 5):
        source = path.read_text("utf-8")
        planted = f"{source}\n\ndef planted(x):\n    return x if {decision} else None\n"
        assert len(list(complaints(planted))) == 1 + len(list(complaints(source)))


@pytest.mark.parametrize("expression", NO_DECISIONS)
def test_codes_types_and_shown_sentences_are_no_decision_by_words(expression):
    assert list(complaints(expression)) == []


@pytest.mark.parametrize(
    "body",
    [
        "text = str(error)\n    return 'busy' in text",
        "v = n.values\n    return v['a'] == 'b'",
        "text = n.message\n    return text == 'no'",
        "text = n.message\n    return text[:4] == 'VNA '",
        "return (text := n.message) and text == 'no'",
        "try: n()\n    except OSError as e: return 'busy' in str(e)",
        "for key, value in n.values.items():\n        if value == 'True': return key",
    ],
)
def test_words_are_followed_into_a_variable(body):
    assert len(list(complaints(f"def busy(error, n):\n    {body}\n"))) == 1


def test_a_message_is_known_by_its_type():
    body = "return str(trouble).startswith('AN AXIS')"
    for kind in ("Message", "Optional[Message]"):
        assert len(list(complaints(f"def busy(trouble: {kind}):\n    {body}\n"))) == 1


def test_a_complaint_names_the_line_and_what_to_use_instead():
    (complaint,) = complaints("x = 1\ny = message.template == x\n")
    assert complaint.startswith("2: ")
    assert "fault's code" in complaint
