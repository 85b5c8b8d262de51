"""The content of survey.json."""

from __future__ import annotations

import json
from typing import Any, Dict, NoReturn

from gpr20_vna_processing.errors import SurveyRefusedError

FORMAT = "gpr20-survey/1"
MAX_BYTES = 1 << 20
MAX_DEPTH = 32


def parse_metadata(text: str) -> Dict[str, Any]:
    """Return the JSON object that describes a survey.

    Raises:
        SurveyRefusedError: The text is too long, not strict JSON, nested too deeply or no
            object.
    """
    size = len(text.encode("utf-8", "surrogatepass"))
    if size > MAX_BYTES:
        raise SurveyRefusedError(f"metadata_json has {size} bytes; at most {MAX_BYTES} are allowed")
    _check_depth(text)
    try:
        values = json.loads(text, parse_constant=_refuse_constant)
        json.dumps(values, allow_nan=False)  # 1e999 is read as infinity
    except ValueError as error:
        raise SurveyRefusedError(f"metadata_json is not strict JSON: {error}") from error
    if not isinstance(values, dict):
        raise SurveyRefusedError(
            f"metadata_json is a {type(values).__name__}; it must be an object: {{...}}"
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


def _check_depth(text: str) -> None:
    # Before parsing: the parser recurses, and Python 3.8 may end the whole process when
    # the recursion limit is reached within it.
    depth = 0
    in_string = escaped = False
    for character in text:
        if escaped:
            escaped = False
        elif in_string:
            escaped = character == "\\"
            in_string = character != '"'
        elif character == '"':
            in_string = True
        elif character in "[{":
            depth += 1
            if depth > MAX_DEPTH:
                raise SurveyRefusedError(
                    f"metadata_json is nested more than {MAX_DEPTH} levels deep"
                )
        elif character in "]}":
            depth -= 1
