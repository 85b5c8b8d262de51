"""Messages as they travel: the fields of ROS messages, answers and JSON, and reading them again.

What is read may come from another version of the software, or from anybody.
"""

from __future__ import annotations

import json
import re
import string
from dataclasses import fields, replace
from typing import Any, Dict, Mapping, Optional, Type, TypeVar

from gpr20_common.errors import UNREADABLE
from gpr20_common.message import CODE_FORMAT, Fault, Message, Severity, in_a_row, verbatim

# A template from elsewhere may neither look into its values nor ask for a gigabyte of blanks.
FIELD_FORMAT = re.compile(r"[<>+]?0?\d?\d?(\.\d\d?)?[defgs%]?")

# More than any message of the robot has, as JSON and as text: a window shows a longer one slowly.
MAX_CHARACTERS = 16_384
# The fault of a longer one is read, but not its sentence.
MAX_READ_CHARACTERS = 1_000_000
# Far deeper ones are read, but exceed the recursion limit where they are shown.
MAX_DEPTH = 32
# Of a fault whose code cannot be read.
UNKNOWN_CODE = "robot.unknown"

Record = TypeVar("Record")


def fields_of(record: Any, kind: Any) -> Dict[str, Any]:
    """Return those fields of a dataclass that a kind of ROS message has too.

    A sentence, or None, becomes its English text and `Message.to_json` in the field NAME_json.
    """
    found = {}
    for name in (one.name for one in fields(record) if one.name in kind.__slots__):
        value = found[name] = getattr(record, name)
        if f"{name}_json" in kind.__slots__:
            found[name] = "" if value is None else str(value)
            found[f"{name}_json"] = "" if value is None else value.to_json()
    return found


def record_of(kind: Type[Record], message: Any, **others: Any) -> Record:
    """Return the dataclass of a message with the fields of `fields_of`, and of other values."""
    found: Dict[str, Any] = {}
    for name in (one.name for one in fields(kind) if hasattr(message, one.name)):  # type: ignore[arg-type]
        value = found[name] = getattr(message, name)
        if hasattr(message, f"{name}_json"):
            message_json = getattr(message, f"{name}_json")
            found[name] = received_message(value, message_json) if value else None
    return kind(**{**found, **others})


def message_fields(message: Message) -> Dict[str, str]:
    """Return the fields that hold a sentence in a ROS message, a response, a result or JSON."""
    return {
        "message": str(message),
        "message_json": message.to_json(),
        "fault_code": message.fault_code,
    }


def message_from(answer: Any) -> Message:
    return received_message(answer.message, answer.message_json, answer.fault_code)


def received_message(text: str, message_json: str, fault_code: str = "") -> Message:
    """Return a message as it came from the ROS graph or out of a file.

    Args:
        text: The complete English text.
        message_json: What `Message.to_json` returned. If it is empty, unreadable or too long,
            the message is the text as it is, with the fault as far as that can be read.
        fault_code: That of the fault that decides, if it came separately.
    """
    message = _read(text, message_json)
    cause = message.cause
    if (cause and cause.code != UNKNOWN_CODE) or not CODE_FORMAT.fullmatch(fault_code):
        return message
    given = replace(cause, code=fault_code, replaces=True) if cause else Fault(fault_code)
    return message.with_fault(given)


def _read(text: str, message_json: str) -> Message:
    plain = verbatim(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}…")
    if len(message_json) > MAX_READ_CHARACTERS:
        return plain
    try:
        record = json.loads(message_json)
        try:
            if len(message_json) > MAX_CHARACTERS:
                raise ValueError("it is too long to be shown")
            return _shown(_message(record))
        except UNREADABLE:
            return plain.with_fault(_fault_without_sentence(record))
    except UNREADABLE:
        return plain


def _shown(message: Message) -> Message:
    """Return a message if it can be shown and sent; raise a ValueError otherwise."""
    text = str(message)
    # A template can repeat a value.
    if len(text) > MAX_CHARACTERS:
        raise ValueError("it is too long to be shown")
    # Half of a character, which JSON can hold, can be neither sent nor shown.
    f"{text}{message.to_json()}".encode()
    return message


def _fault_without_sentence(record: Any) -> Optional[Fault]:
    """Return the fault that decides in a message whose sentences cannot be read."""
    message = _faults_only(record, 1)
    return message.cause and replace(
        message.cause,
        may_move=message.may_move,
        can_continue=message.can_continue,
        replaces=True,
    )


def _faults_only(record: Mapping[str, Any], depth: int) -> Message:
    inside = (
        one
        for value in record.get("values", {}).values()
        for one in (value if isinstance(value, list) else [value])
        if isinstance(one, dict) and depth < MAX_DEPTH
    )
    message = in_a_row(_faults_only(one, depth + 1) for one in inside)
    return message.with_fault(_fault(record["fault"], depth)) if "fault" in record else message


def _message(record: Any, depth: int = 1) -> Message:
    if depth > MAX_DEPTH:
        raise ValueError(f"messages are nested more than {MAX_DEPTH} levels deep")
    fields = set()
    for _words, name, field_format, _conversion in string.Formatter().parse(record["template"]):
        if name is None:
            continue
        if not (name.isidentifier() and FIELD_FORMAT.fullmatch(str(field_format))):
            raise ValueError(f"the field {name!r} of a template has no plain name or format")
        # Each level of messages inside messages would double the text.
        if name in fields and isinstance(record["values"][name], (dict, list)):
            raise ValueError(f"the field {name!r} repeats a message")
        fields.add(name)
    values = {}
    for name, value in record["values"].items():
        if isinstance(value, dict):
            value = _message(value, depth + 1)
        elif isinstance(value, list):
            value = tuple(_message(one, depth + 1) for one in value)
        values[name] = value
    message = Message(record["template"], details=record.get("details", ""), **values)
    return message.with_fault(_fault(record["fault"], depth)) if "fault" in record else message


def _fault(record: Any, depth: int) -> Fault:
    """Read the fault of a message; what a later version may have changed is taken as grave."""
    code = str(record.get("code"))
    named = {one.value: one for one in Severity}
    try:
        remedy = _shown(_message(record.get("remedy"), depth + 1))
    except UNREADABLE:
        remedy = None
    return Fault(
        code=code if CODE_FORMAT.fullmatch(code) else UNKNOWN_CODE,
        remedy=remedy,
        severity=named.get(str(record.get("severity")), Severity.FAULT),
        may_move=record.get("may_move", False) is not False,
        can_continue=record.get("can_continue", True) is True,
        replaces=record.get("replaces", False) is True,
    )
