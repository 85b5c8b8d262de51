"""The annotation of a survey as attributes of its Dataset."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import MARKERS, present_markers

NAME, OPERATOR, SITE, NOTES = "survey_name", "operator", "site", "survey_notes"
LATITUDE, LONGITUDE, HEADING = "latitude_deg", "longitude_deg", "heading_deg"
ATTRIBUTES = (NAME, OPERATOR, SITE, NOTES, LATITUDE, LONGITUDE, HEADING)


def annotation_attributes(description: Mapping[str, Any], notes: List[Message]) -> Dict[str, Any]:
    """Return the attributes; those of what is empty are left out.

    Args:
        description: Content of survey.json.
        notes: A remark on an annotation that is not allowed is added here.
    """
    try:
        annotation = annotation_of(description)
    except InvalidValueError as error:
        notes.append(
            Message("the annotation in survey.json is not valid: {reason}", reason=error.message)
        )
        return {}
    texts = {
        NAME: annotation.name,
        OPERATOR: annotation.operator,
        SITE: annotation.site,
        NOTES: annotation.notes,
    }
    found: Dict[str, Any] = {name: text for name, text in texts.items() if text}
    if annotation.position is not None:
        found[LATITUDE] = annotation.position.latitude_deg
        found[LONGITUDE] = annotation.position.longitude_deg
    if annotation.heading_deg is not None:
        found[HEADING] = annotation.heading_deg
    return found


def marker_attributes(description: Mapping[str, Any], notes: List[Message]) -> Dict[str, Any]:
    """Return the number of markers that were not removed, if there are any.

    Args:
        description: Content of survey.json.
        notes: A remark on markers that are not allowed is added here.
    """
    try:
        count = len(present_markers(description))
    except InvalidValueError as error:
        notes.append(error.message)
        return {}
    return {MARKERS: count} if count else {}


def position_text(attributes: Mapping[str, Any]) -> str:
    """Return latitude and longitude [deg] as text; empty if they are not known."""
    if LATITUDE not in attributes or LONGITUDE not in attributes:
        return ""
    return f"{float(attributes[LATITUDE])!r}, {float(attributes[LONGITUDE])!r}"
