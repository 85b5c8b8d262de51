"""What differs between two copies of a survey's description."""

from __future__ import annotations

import json
from typing import Any, Dict, Iterator, List, NamedTuple

from gpr20_survey.folder import survey_metadata

MAX_SHOWN_CHARACTERS = 80
MISSING = "(missing)"


class Difference(NamedTuple):
    """One entry that two descriptions do not have in common."""

    key: str
    """With the keys above it, such as parameters/y_stop_mm."""
    first: str
    """The value in the first description, as JSON."""
    second: str


def constant_entries(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return the entries that never change after the start of a survey."""
    return {
        key: value for key, value in description.items() if key not in survey_metadata.LATER_KEYS
    }


def differences(first: Dict[str, Any], second: Dict[str, Any]) -> List[Difference]:
    """Return what differs in the constant entries of two descriptions.

    The type counts: 1, 1.0 and true are three values. The order of the entries does not.
    """
    return list(_compare("", constant_entries(first), constant_entries(second)))


def _compare(place: str, first: Any, second: Any) -> Iterator[Difference]:
    if isinstance(first, dict) and isinstance(second, dict):
        for key in [*first, *(one for one in second if one not in first)]:
            inner = f"{place}/{key}" if place else key
            if key not in first or key not in second:
                yield Difference(inner, _shown(first, key), _shown(second, key))
            else:
                yield from _compare(inner, first[key], second[key])
    elif isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        for number, (one, other) in enumerate(zip(first, second)):
            yield from _compare(f"{place}/{number}", one, other)
    elif json.dumps(first) != json.dumps(second):
        yield Difference(place, _text(first), _text(second))


def _shown(values: Dict[str, Any], key: str) -> str:
    return _text(values[key]) if key in values else MISSING


def _text(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= MAX_SHOWN_CHARACTERS else text[: MAX_SHOWN_CHARACTERS - 3] + "..."
