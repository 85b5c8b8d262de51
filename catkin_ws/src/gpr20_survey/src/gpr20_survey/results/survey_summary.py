"""One survey of the data folder, with the fields of gpr20_msgs/SurveySummary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message


@dataclass(frozen=True)
class SurveySummary:
    """One survey of the data folder; an outcome, verdict or problem may be empty or None.

    A cell of the map is 100 [%] only if all of it is stored, and 0 only if none is.
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
    site: str = ""
    operator: str = ""
