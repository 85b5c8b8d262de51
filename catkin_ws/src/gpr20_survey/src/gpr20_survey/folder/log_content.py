"""What the records of a survey's log say together: the description of the survey."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Sequence

from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS

LOG = "log"
"""Key of a description under which a reader gets records of the log beside it."""
UNCONFIRMED = "unconfirmed"
"""Key of a description: entries that nothing vouches for, by their names, with the reason."""
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
    """Return what records say, in their order; the first one is the plan."""
    description: Description = {}
    for record in records:
        add_to(description, record)
    return description


def add_to(description: Description, record: LogRecord) -> None:
    """Change a description by one record; those of other kinds than below change nothing."""
    apply = _APPLY.get(record.kind)
    if apply is not None:
        apply(description, record.values, record)


def log_values(values: Mapping[str, Any], kind: Kind) -> List[Dict[str, Any]]:
    """Return the facts of a kind, of the records that a reader gets with a description."""
    log = values.get(LOG)
    entries = [one for one in log if isinstance(one, dict)] if isinstance(log, list) else []
    found = [one.get("values") for one in entries if one.get("kind") == kind.value]
    return [one for one in found if isinstance(one, dict)]


def _plan(description: Description, values: Mapping[str, Any], record: LogRecord) -> None:
    if record.number == 0:  # what was planned does not change
        description.update(values)


def _end(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
    description.update(values)


def _set(key: str) -> Callable[[Description, Mapping[str, Any], LogRecord], None]:
    def apply(description: Description, values: Mapping[str, Any], _record: LogRecord) -> None:
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
    Kind.END.value: _end,
    Kind.ANNOTATION.value: _set(ANNOTATION),
    Kind.REPORT.value: _set("report"),
    Kind.MARKER.value: _marker,
    Kind.MARKER_REMOVED.value: _removed,
    Kind.RESUME.value: _resume,
    Kind.UNCONFIRMED.value: _unconfirmed,
}
