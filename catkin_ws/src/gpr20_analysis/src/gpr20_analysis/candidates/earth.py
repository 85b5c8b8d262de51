"""The place of a survey's area on the earth, from the attributes of its data."""

from __future__ import annotations

from typing import Any, Mapping, Optional

from gpr20_analysis.read.annotation_attributes import HEADING, LATITUDE, LONGITUDE
from gpr20_survey.results.area_position import AreaPosition


def area_position(attributes: Mapping[str, Any]) -> Optional[AreaPosition]:
    """Return where the area of a survey is on the earth; None if that is not known."""
    names = (LATITUDE, LONGITUDE, HEADING)
    if not all(name in attributes for name in names):
        return None
    return AreaPosition(*(float(attributes[name]) for name in names))
