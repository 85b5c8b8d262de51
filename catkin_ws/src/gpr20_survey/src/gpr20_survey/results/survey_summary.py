"""What a list of surveys says about one of them, with the fields of gpr20_msgs/SurveySummary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message


@dataclass(frozen=True)
class SurveySummary:
    """One survey of the data folder.

    Attributes:
        survey_id: UUID; empty if survey.json cannot be read.
        started: ISO 8601, UTC; empty if survey.json cannot be read.
        outcome: How it ended, as in survey.json; empty: it runs, or was cut off.
        stored_traces: Number of files in its folder of traces.
        planned_traces: According to its parameters; 0 if they cannot be read.
        verdict: On the coverage, from the survey's end; None if there is none.
        complete: Whether it is finished, with all planned traces.
        simulated: Whether the data show no real ground.
        refines: Id of the survey that it measures more finely; empty: none.
        width_mm: Of its area, along X; 0 if it is not known.
        height_mm: Along Y.
        map_columns: Of the map of what is stored; 0: there is none.
        map_percent: Stored share of each cell [%], row by row, X and Y ascending; 100 only
            if all are stored, 0 only if none is.
        fault_code: Of why it ended; empty: nothing went wrong, or it is not known.
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
    width_mm: float = 0.0
    height_mm: float = 0.0
    map_columns: int = 0
    map_rows: int = 0
    map_percent: bytes = b""
    fault_code: str = ""
    site: str = ""
    operator: str = ""
