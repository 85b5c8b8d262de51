"""The description of a survey: what its log says, and survey.json shows."""

from __future__ import annotations

import json
import re
from typing import Any, Dict, NoReturn

from gpr20_common.message import Message, verbatim
from gpr20_survey.errors import SurveyRefusedError

FORMAT = "gpr20-survey/1"
REASON_MESSAGE = "reason_message"  # template, values and fault of the reason
FAULT_CODE = "fault_code"  # of why it ended; empty: nothing went wrong
INTERRUPTED = "interrupted"  # outcome of a survey that was closed to be resumed later
MAX_BYTES = 1 << 20
MAX_REPORT_BYTES = 8 << 20  # one letter per planned sample, and what failed
MAX_FILE_BYTES = 32 << 20
MAX_DEPTH = 32
# A record of the log holds an object of that depth.
MAX_FILE_DEPTH = MAX_DEPTH + 4
# How deep a message may be that is part of a record.
MAX_MESSAGE_DEPTH = 24

NOT_ENDED: Dict[str, Any] = {
    "ended": None,
    "outcome": None,
    "reason": "",
    REASON_MESSAGE: None,
    FAULT_CODE: "",
}
START: Dict[str, Any] = {**NOT_ENDED, "stored_traces": 0}
"""What a plan says of the end."""
# A whole text, or the end of one that does not end.
_TEXT = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"?', re.DOTALL)
_BRACKET = re.compile(r"[\[{]|[\]}]")


def parse_object(
    text: str, name: str, max_bytes: int = MAX_BYTES, max_depth: int = MAX_DEPTH
) -> Dict[str, Any]:
    """Return a JSON object that came from outside; messages call it by the name.

    Raises:
        SurveyRefusedError: The text is too long, not strict JSON, nested too deeply or no object.
    """
    check_size(len(text.encode("utf-8", "surrogatepass")), name, max_bytes)
    # Before parsing: the parser recurses, and Python 3.8 may end the whole process when the
    # recursion limit is reached within it.
    depth = 0
    for bracket in _BRACKET.findall(_TEXT.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > max_depth:
            raise SurveyRefusedError(
                Message("{name} is nested more than {most} levels deep", name=name, most=max_depth)
            )
    try:
        values = json.loads(text, parse_constant=_refuse_constant)
        json.dumps(values, allow_nan=False)  # 1e999 is read as infinity
    except ValueError as error:
        raise SurveyRefusedError(
            Message("{name} is not strict JSON", name=name, details=error)
        ) from error
    if not isinstance(values, dict):
        raise SurveyRefusedError(
            Message(
                "{name} is of type {type}; it must be an object, {example}",
                name=name,
                type=type(values).__name__,
                example="{...}",
            )
        )
    return values


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed in JSON")


def check_size(size: int, name: str, max_bytes: int) -> None:
    """Check the size of a text or a file [bytes].

    Raises:
        SurveyRefusedError: It is too large.
    """
    if size > max_bytes:
        raise SurveyRefusedError(
            Message(
                "{name} has {size} bytes; at most {most} are allowed",
                name=name,
                size=size,
                most=max_bytes,
            )
        )


def encode(values: Dict[str, Any]) -> bytes:
    """Return the content of survey.json: strict JSON, ASCII, for people to read."""
    return (json.dumps(values, allow_nan=False, indent=2) + "\n").encode("ascii")


def message_record(message: Message) -> Dict[str, Any]:
    """Return a message as the log holds it: template, values, details and fault.

    Where strict JSON cannot hold the values, or they are nested too deeply, it is the text alone.
    """
    try:
        return parse_object(message.to_json(), "message", max_depth=MAX_MESSAGE_DEPTH)
    except SurveyRefusedError:
        plain = verbatim(str(message)).with_fault(message.cause)
        return dict(json.loads(plain.to_json()))
