"""What the records of a survey's log say together: the description of the survey."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Sequence

from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_metadata import NOT_ENDED
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS

LOG = "log"
"""Key of a description under which a reader gets records of the log beside it."""
UNCONFIRMED = "unconfirmed"
"""Key of a description: entries that nothing vouches for, by their names, with the reason."""

Description = Dict[str, Any]


def description_of(records: Sequence[LogRecord]) -> Description:
    """Return what records say, in their order; the first one is the plan."""
    description: Description = {}
    for record in records:
        add_to(description, record)
    return description


def add_to(description: Description, record: LogRecord) -> None:
    """Change a description by one record; those of other kinds than below change nothing."""
    kind, values = record.kind, record.values
    if kind == Kind.END or (kind == Kind.PLAN and record.number == 0):
        description.update(values)
    elif kind in (Kind.ANNOTATION, Kind.REPORT):
        description[ANNOTATION if kind == Kind.ANNOTATION else "report"] = values
    elif kind == Kind.MARKER:
        description[MARKERS] = [*description.get(MARKERS, []), values]
    elif kind == Kind.MARKER_REMOVED:
        description[MARKERS] = [
            {**one, **values} if one.get("marker_id") == values.get("marker_id") else one
            for one in description.get(MARKERS, [])
        ]
    elif kind == Kind.RESUME:
        resumed = [*description.get("resumed", []), record.time]
        description.update({**NOT_ENDED, **values, "resumed": resumed})
    elif kind == Kind.UNCONFIRMED:
        entries = values.get("entries", {})
        description[UNCONFIRMED] = {**description.get(UNCONFIRMED, {}), **entries}


def log_values(values: Mapping[str, Any], kind: Kind) -> List[Dict[str, Any]]:
    """Return the facts of a kind, of the records that a reader gets with a description."""
    log = values.get(LOG)
    entries = [one for one in log if isinstance(one, dict)] if isinstance(log, list) else []
    found = [one.get("values") for one in entries if one.get("kind") == kind.value]
    return [one for one in found if isinstance(one, dict)]
