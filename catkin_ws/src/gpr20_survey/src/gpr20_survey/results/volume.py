"""A mounted removable volume, and what of a survey is exported to it."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class ExportPart(enum.Enum):
    """One file of an export, as messages of ROS call it."""

    REPORT_HTML = "report-html"
    CANDIDATES_CSV = "candidates-csv"
    CANDIDATES_GEOJSON = "candidates-geojson"
    SURVEY_ZIP = "survey-zip"


@dataclass(frozen=True)
class Volume:
    """A mounted USB stick, or another removable volume; but for the device it is sent as it is.

    Attributes:
        device: Its number; another stick at the same place has another one. 0: not known, as on
            other computers.
    """

    path: str
    name: str
    free_bytes: int
    writable: bool
    device: int = 0
