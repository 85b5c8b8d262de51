"""The description of a survey: what its log says, and survey.json shows."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Dict, NoReturn

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.trace import utc_time

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

# What survey.json holds of facts that came after the start, and the records themselves.
LOGGED_KEYS = ("resumed", "report", MARKERS, "log", "unconfirmed", "content_sha256")

# What the storage itself writes into survey.json, in addition to the metadata.
OWN_KEYS = frozenset(
    {
        "format",
        "survey_id",
        "started",
        "ended",
        "outcome",
        "reason",
        REASON_MESSAGE,
        FAULT_CODE,
        "stored_traces",
        "software_revision",
        *LOGGED_KEYS,
    }
)

# A whole text, or the end of one that does not end; else a bracket.
_TOKEN = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"?|[\[{]|[\]}]', re.DOTALL)


def parse_object(
    text: str, name: str, max_bytes: int = MAX_BYTES, max_depth: int = MAX_DEPTH
) -> Dict[str, Any]:
    """Return a JSON object that came from outside.

    Args:
        text: The JSON.
        name: What it is, for the message.
        max_bytes: How long it may be [bytes].
        max_depth: How deep it may be nested.

    Raises:
        SurveyRefusedError: The text is too long, not strict JSON, nested too deeply or no
            object.
    """
    check_size(len(text.encode("utf-8", "surrogatepass")), name, max_bytes)
    _check_depth(text, name, max_depth)
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


def parse_metadata(text: str) -> Dict[str, Any]:
    """Return the JSON object that describes a survey.

    Raises:
        SurveyRefusedError: It is not allowed; see `parse_object`. Or its annotation is not.
    """
    values = parse_object(text, "metadata_json")
    for key in LOGGED_KEYS:
        if key in values:
            raise SurveyRefusedError(
                Message(
                    "metadata_json holds '{key}', which the storage writes itself; leave it out",
                    key=key,
                )
            )
    _check_annotation(values)
    return values


def _check_annotation(values: Dict[str, Any]) -> None:
    try:
        annotation_of(values)
    except InvalidValueError as error:
        raise SurveyRefusedError(
            Message("the annotation in metadata_json is refused: {reason}", reason=error.message)
        ) from error


def combine(metadata: Dict[str, Any], own: Dict[str, Any]) -> Dict[str, Any]:
    """Return the metadata with the storage's own entries.

    Raises:
        SurveyRefusedError: The metadata contradict one of the storage's own entries.
    """
    for key, value in own.items():
        if key in metadata and metadata[key] != value:
            raise SurveyRefusedError(
                Message(
                    "metadata_json holds '{key}', which the storage writes itself; leave it out",
                    key=key,
                    details=repr(str(metadata[key])[:64]),
                )
            )
    return {**own, **{key: value for key, value in metadata.items() if key not in own}}


def metadata_of(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return the part of the description that was given to `open_survey`."""
    return {key: value for key, value in description.items() if key not in OWN_KEYS}


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


def check_format(values: Dict[str, Any], path: Path) -> None:
    """Check that values are those of a survey.json.

    Raises:
        SurveyRefusedError: They are not.
    """
    if values.get("format") != FORMAT or not isinstance(values.get("survey_id"), str):
        raise SurveyRefusedError(
            Message(
                "{path} does not describe a survey of format {format}",
                path=printable(path),
                format=FORMAT,
            ),
            fault=faults.OTHER_FORMAT,
        )


def started_us(description: Dict[str, Any]) -> int:
    """Return when a survey started [us since 1970, UTC].

    Raises:
        SurveyRefusedError: Its survey.json does not hold that time.
    """
    try:
        return utc_time.parse_iso(description["started"])
    except (KeyError, TypeError, ValueError) as error:
        raise SurveyRefusedError(
            Message("'started' in survey.json is missing or is not a time", details=error),
            fault=faults.DESCRIPTION_LOST,
        ) from error


def encode(values: Dict[str, Any]) -> bytes:
    """Return the content of survey.json: strict JSON, ASCII, for people to read."""
    return (json.dumps(values, allow_nan=False, indent=2) + "\n").encode("ascii")


def message_record(message: Message) -> Dict[str, Any]:
    """Return a message as survey.json holds it: template, values, details and fault.

    Where strict JSON cannot hold the values, or they are nested too deeply, it is the text alone.
    """
    text = message.to_json()
    try:
        values = parse_object(text, "message")
        _check_depth(text, "message", MAX_MESSAGE_DEPTH)
    except SurveyRefusedError:
        plain = verbatim(str(message)).with_fault(message.cause)
        values = json.loads(plain.to_json())
    return values


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed in JSON")


def _check_depth(text: str, name: str, most: int = MAX_DEPTH) -> None:
    # Before parsing: the parser recurses, and Python 3.8 may end the whole process when
    # the recursion limit is reached within it.
    depth = 0
    for token in _TOKEN.finditer(text):
        if token.group() in "[{":
            depth += 1
            if depth > most:
                raise SurveyRefusedError(
                    Message("{name} is nested more than {most} levels deep", name=name, most=most)
                )
        elif token.group() in "]}":
            depth -= 1
