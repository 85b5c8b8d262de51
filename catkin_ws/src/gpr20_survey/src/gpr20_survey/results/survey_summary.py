"""One survey of the data folder, as fields of gpr20_msgs/SurveySummary, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Optional

from gpr20_common.message import Message
from gpr20_common.sent_message import fields_of, record_of


@dataclass(frozen=True)
class Thumbnail:
    """The area of a survey, and how much of each part of it is stored.

    Attributes:
        width_mm: Of the area, along X [mm]; 0 if it is not known.
        height_mm: Along Y [mm].
        columns: Of the map; 0: there is none.
        rows: Of the map.
        percent: Stored share of each cell [%], row by row, X and Y ascending; 100 only
            if all are stored, 0 only if none is.
    """

    width_mm: float = 0.0
    height_mm: float = 0.0
    columns: int = 0
    rows: int = 0
    percent: bytes = b""


NO_THUMBNAIL = Thumbnail()


@dataclass(frozen=True)
class SurveySummary:
    """What a list of surveys says about one of them.

    Attributes:
        folder: Name of its folder.
        survey_id: UUID; empty if survey.json cannot be read.
        started: ISO 8601, UTC; empty if survey.json cannot be read.
        outcome: How it ended, as in survey.json; empty: it runs, or was cut off.
        stored_traces: Number of files in its folder of traces.
        planned_traces: According to its parameters; 0 if they cannot be read.
        verdict: On the coverage, from the survey's end; None if there is none.
        complete: Whether it is finished, with all planned traces.
        simulated: Whether the data show no real ground.
        problem: Why survey.json cannot be read; None if it can.
        name: What people call it; empty if it has none.
        refines: Id of the survey that it measures more finely; empty: none.
        thumbnail: Its area.
        fault_code: Of why it ended; empty: nothing went wrong, or it is not known.
        site: Where it was measured, in words; empty if nobody wrote it.
        operator: Who measured it.
    """

    folder: str
    survey_id: str = ""
    started: str = ""
    outcome: str = ""
    stored_traces: int = 0
    planned_traces: int = 0
    verdict: Optional[Message] = None
    complete: bool = False
    simulated: bool = False
    problem: Optional[Message] = None
    name: str = ""
    refines: str = ""
    thumbnail: Thumbnail = NO_THUMBNAIL
    fault_code: str = ""
    site: str = ""
    operator: str = ""


MAP = {
    **{"width_mm": "width_mm", "height_mm": "height_mm"},
    **{"columns": "map_columns", "rows": "map_rows", "percent": "map_percent"},
}
"""The fields of a thumbnail and those of the message."""


def summary_fields(summary: SurveySummary, kind: Any) -> Dict[str, Any]:
    """Return the fields of a summary; the class of the message says which it has."""
    area = {sent: getattr(summary.thumbnail, own) for own, sent in MAP.items()}
    return {**fields_of(summary, kind), **area}


def summary_from(message: Any) -> SurveySummary:
    """Return the summary of a message."""
    thumbnail = Thumbnail(**{own: getattr(message, sent) for own, sent in MAP.items()})
    return record_of(SurveySummary, message, thumbnail=thumbnail)
