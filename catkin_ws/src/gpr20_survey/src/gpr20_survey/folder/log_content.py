"""What the records of a survey's log say together: the content of survey.json."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple

from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS

LOG = "log"
"""Key of survey.json under which it holds the records themselves."""
UNCONFIRMED = "unconfirmed"
"""Key of survey.json: entries that nothing vouches for, by their names, with the reason."""
# The entries that change at the end, as they are before; then those that change earlier too.
NOT_ENDED: Dict[str, Any] = {
    "ended": None,
    "outcome": None,
    "reason": "",
    survey_metadata.REASON_MESSAGE: None,
    survey_metadata.FAULT_CODE: "",
}
START: Dict[str, Any] = {**NOT_ENDED, "stored_traces": 0}

Description = Dict[str, Any]


def description_of(records: Sequence[LogRecord]) -> Description:
    """Return the content of survey.json, without its records.

    Args:
        records: All that are known, in their order; the first one, the plan, may be missing.
    """
    description: Description = {}
    for record in records:
        values = record.values
        apply = _APPLY.get(record.kind)
        if apply is not None and values is not None:
            apply(description, values, record)
    return description


def view_of(records: Sequence[LogRecord]) -> bytes:
    """Return survey.json: what the records say, and the records."""
    shown = [one.as_json() for one in without_replaced(records)]
    return survey_metadata.encode({**description_of(records), LOG: shown})


def log_entries(values: Mapping[str, Any]) -> Tuple[List[Dict[str, Any]], int]:
    """Return the readable entries of the log in a survey.json, and how many are not readable."""
    log = values.get(LOG)
    entries = log if isinstance(log, list) else []
    readable = [
        one
        for one in entries
        if isinstance(one, dict) and isinstance(one.get("values") or {}, dict)
    ]
    return readable, len(entries) - len(readable)


def without_replaced(records: Sequence[LogRecord]) -> List[LogRecord]:
    """Return the records without the values of reports that a later report replaced."""
    reports = [one.number for one in records if one.kind == Kind.REPORT.value]
    replaced = set(reports[:-1])
    return [one.without_values() if one.number in replaced else one for one in records]


def _plan(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
    description.update(values)


def _set(key: str) -> Callable[[Description, Mapping[str, Any], LogRecord], None]:
    def apply(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
        # At the end: the order must not depend on former values, which may have been left out.
        description.pop(key, None)
        description[key] = values

    return apply


def _marker(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
    description[MARKERS] = [*description.get(MARKERS, []), values]


def _removed(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
    markers = description.get(MARKERS, [])
    same = values.get("marker_id")
    description[MARKERS] = [
        {**one, **values} if one.get("marker_id") == same else one for one in markers
    ]


def _resume(description: Description, values: Mapping[str, Any], record: LogRecord) -> None:
    description.update(NOT_ENDED)
    description.update(values)
    description["resumed"] = [*description.get("resumed", []), record.time]


def _unconfirmed(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
    entries = values.get("entries", {})
    description[UNCONFIRMED] = {**description.get(UNCONFIRMED, {}), **entries}


_APPLY: Dict[str, Callable[[Description, Mapping[str, Any], LogRecord], None]] = {
    Kind.PLAN.value: _plan,
    Kind.END.value: _plan,
    Kind.ANNOTATION.value: _set(ANNOTATION),
    Kind.REPORT.value: _set("report"),
    Kind.MARKER.value: _marker,
    Kind.MARKER_REMOVED.value: _removed,
    Kind.RESUME.value: _resume,
    Kind.UNCONFIRMED.value: _unconfirmed,
}
