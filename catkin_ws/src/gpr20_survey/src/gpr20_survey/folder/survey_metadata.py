"""The content of survey.json."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Dict, NoReturn

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.trace import utc_time

FORMAT = "gpr20-survey/1"
INTERRUPTED = "interrupted"  # outcome of a survey that was closed to go on later
MAX_BYTES = 1 << 20
MAX_REPORT_BYTES = 8 << 20  # one letter per planned sample, and what failed
MAX_FILE_BYTES = 32 << 20
MAX_DEPTH = 32

# What the storage itself writes into survey.json, beside the metadata.
OWN_KEYS = frozenset(
    {
        "format",
        "survey_id",
        "started",
        "ended",
        "outcome",
        "reason",
        "stored_traces",
        "software_revision",
        "resumed",
        "report",
    }
)

# Those of them that change while the survey goes on.
LATER_KEYS = ("ended", "outcome", "reason", "stored_traces", "resumed", "report")

# A whole text, or the end of one that does not end; else a bracket.
_TOKEN = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"?|[\[{]|[\]}]', re.DOTALL)


def parse_object(text: str, name: str, max_bytes: int = MAX_BYTES) -> Dict[str, Any]:
    """Return a JSON object that came from outside.

    Args:
        text: The JSON.
        name: What it is, for the message.
        max_bytes: How long it may be [bytes].

    Raises:
        SurveyRefusedError: The text is too long, not strict JSON, nested too deeply or no
            object.
    """
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > max_bytes:
        raise SurveyRefusedError(f"{name} has {size} bytes; at most {max_bytes} are allowed")
    _check_depth(text, name)
    try:
        values = json.loads(text, parse_constant=_refuse_constant)
        json.dumps(values, allow_nan=False)  # 1e999 is read as infinity
    except ValueError as error:
        raise SurveyRefusedError(f"{name} is not strict JSON: {error}") from error
    if not isinstance(values, dict):
        raise SurveyRefusedError(
            f"{name} is a {type(values).__name__}; it must be an object: {{...}}"
        )
    return values


def parse_metadata(text: str) -> Dict[str, Any]:
    """Return the JSON object that describes a survey.

    Raises:
        SurveyRefusedError: It is not allowed; see `parse_object`.
    """
    values = parse_object(text, "metadata_json")
    for key in ("resumed", "report"):
        if key in values:
            raise SurveyRefusedError(
                f"metadata_json has its own '{key}'; leave it out, the storage writes that entry"
            )
    return values


def combine(metadata: Dict[str, Any], own: Dict[str, Any]) -> Dict[str, Any]:
    """Return the metadata with the storage's own entries.

    Raises:
        SurveyRefusedError: The metadata say something else about one of the own entries.
    """
    for key, value in own.items():
        if key in metadata and metadata[key] != value:
            raise SurveyRefusedError(
                f"metadata_json has its own '{key}' ({str(metadata[key])[:64]!r}); leave it out, "
                "the storage writes that entry"
            )
    return {**own, **{key: value for key, value in metadata.items() if key not in own}}


def metadata_of(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return what of survey.json was given by `open_survey`."""
    return {key: value for key, value in description.items() if key not in OWN_KEYS}


def with_start_of(description: Dict[str, Any], copy: Dict[str, Any]) -> Dict[str, Any]:
    """Return a description with all that never changes taken from a copy of its start."""
    later = {key: description[key] for key in LATER_KEYS if key in description}
    return {**copy, **later}


def read_description(path: Path) -> Dict[str, Any]:
    """Return the content of a survey.json.

    Raises:
        SurveyRefusedError: It is missing or is not as the storage writes it.
    """
    try:
        with open(open_regular(path, follow_link=True), "rb") as stream:
            text = stream.read(MAX_FILE_BYTES + 1).decode("ascii")
        values = parse_object(text, path.name, MAX_FILE_BYTES)
    except (OSError, UnicodeDecodeError, SurveyRefusedError) as error:
        raise SurveyRefusedError(
            f"{path} cannot be read ({error}); a copy of it as it was at the start is attached "
            "to survey.mcap"
        ) from error
    check_format(values, path)
    return values


def check_format(values: Dict[str, Any], path: Path) -> None:
    """Check that values are those of a survey.json.

    Raises:
        SurveyRefusedError: They are not.
    """
    if values.get("format") != FORMAT or not isinstance(values.get("survey_id"), str):
        raise SurveyRefusedError(f"{path} does not describe a survey of format {FORMAT}")


def started_us(description: Dict[str, Any]) -> int:
    """Return when a survey started [us since 1970, UTC].

    Raises:
        SurveyRefusedError: Its survey.json does not say so.
    """
    try:
        return utc_time.parse_iso(description["started"])
    except (KeyError, TypeError, ValueError) as error:
        raise SurveyRefusedError(f"'started' of survey.json is no time: {error}") from error


def encode(values: Dict[str, Any]) -> bytes:
    """Return the content of survey.json: strict JSON, ASCII, for people to read."""
    return (json.dumps(values, allow_nan=False, indent=2) + "\n").encode("ascii")


def as_texts(values: Dict[str, Any]) -> Dict[str, str]:
    """Return the top entries as texts: texts as they are, all else as JSON."""
    return {
        key: value if isinstance(value, str) and value.isprintable() else json.dumps(value)
        for key, value in values.items()
    }


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed in JSON")


def _check_depth(text: str, name: str) -> None:
    # Before parsing: the parser recurses, and Python 3.8 may end the whole process when
    # the recursion limit is reached within it.
    depth = 0
    for token in _TOKEN.finditer(text):
        if token.group() in "[{":
            depth += 1
            if depth > MAX_DEPTH:
                raise SurveyRefusedError(f"{name} is nested more than {MAX_DEPTH} levels deep")
        elif token.group() in "]}":
            depth -= 1
