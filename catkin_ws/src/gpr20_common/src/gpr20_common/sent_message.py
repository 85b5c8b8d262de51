"""Messages as JSON, and reading them again, from JSON and from the fields of gpr20_msgs/Fault.

What is read may come from another version of the software, or from anybody.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections import Counter
from typing import Any, Dict, Optional

from gpr20_common.errors import UNREADABLE
from gpr20_common.message import CODE_FORMAT, Fault, Message, Severity, verbatim

# A template from elsewhere may neither look into its values nor ask for a gigabyte of blanks.
FIELD = re.compile(r"\{([^\W\d]\w*)(?::[<>+]?0?\d?\d?(?:\.\d\d?)?[defgs%]?)?\}")

# More than any message of the robot has, as JSON and as text: a window shows a longer one slowly.
MAX_CHARACTERS = 16_384
# No JSON of the robot is longer.
MAX_READ_CHARACTERS = 1_000_000
# Far deeper ones are read, but exceed the recursion limit where they are shown.
MAX_DEPTH = 32
# Of a fault whose code cannot be read, or is not there.
UNKNOWN_CODE = "robot.unknown"


def received_message(text: str, record: Any) -> Message:
    """Return a message from its English text and what `Message.record` returned, maybe as JSON.

    If a sentence is missing there, unreadable or too long, it is the text, with the fault.
    """
    return _received(text, _parsed(record), 1)


def _received(text: str, record: Any, depth: int) -> Message:
    text = text.encode(errors="replace").decode()
    plain = verbatim(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}…")
    if not isinstance(record, dict):
        return plain
    try:
        message = _message(record, depth)
        shown, sent = str(message), message.to_json()
        # A template can repeat a value.
        if max(len(shown), len(sent)) > MAX_CHARACTERS:
            raise ValueError("it is too long to be shown")
        # Half of a character, which JSON can hold, can be neither sent nor shown.
        f"{shown}{sent}".encode()
        return message
    except UNREADABLE:
        return plain.with_fault(_fault(record, depth))


def _parsed(value: Any) -> Any:
    """Return a value that may have come as JSON; None if that is none, or far too long."""
    if not isinstance(value, str):
        return value
    with contextlib.suppress(*UNREADABLE):
        return json.loads(value) if len(value) <= MAX_READ_CHARACTERS else None
    return None


def _message(record: Any, depth: int) -> Message:
    values, sentence = _parsed(record["values"]), record["sentence"]
    if depth > MAX_DEPTH:
        raise ValueError(f"messages are nested more than {MAX_DEPTH} levels deep")
    plain = sentence.replace("{{", "").replace("}}", "")
    names = Counter(FIELD.findall(plain))
    if not plain or set("{}") & set(FIELD.sub("", plain)):
        raise ValueError("it has no sentence, or a field without a plain name or format")
    for name, value in values.items():
        # Each level of messages inside messages would double the text.
        if isinstance(value, (dict, list)) and names[name] > 1:
            raise ValueError(f"the field {name!r} repeats a message")
        if isinstance(value, dict):
            value = _message(value, depth + 1)
        elif isinstance(value, list):
            value = tuple(_message(one, depth + 1) for one in value)
        values[name] = value
    message = Message(sentence, details=record.get("details", ""), **values)
    return message.with_fault(_fault(record, depth))


def _fault(record: Dict[str, Any], depth: int) -> Optional[Fault]:
    """Read the fault of a message; what a later version may have changed is taken as grave."""
    code = str(record.get("code", ""))
    moves = record.get("may_move", bool(code)) is not False
    if not (code or moves or record.get("remedy")):
        return None
    named = {one.value: one for one in Severity}
    said = {name: record.get(f"remedy_{name}") for name in ("sentence", "values")}
    remedy = _received(str(record.get("remedy", "")), said, depth + 1)
    return Fault(
        code=code if CODE_FORMAT.fullmatch(code) else UNKNOWN_CODE,
        remedy=remedy if str(remedy) else None,
        severity=named.get(str(record.get("severity")), Severity.FAULT),
        may_move=moves,
        can_continue=record.get("can_continue", True) is True,
    )
