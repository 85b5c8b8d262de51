"""The facts that others may add to the log of a survey: what their values must be."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any, Collection, Dict, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.folder.recovery import Change, Fact
from gpr20_survey.folder.survey_metadata import MAX_BYTES, MAX_REPORT_BYTES, parse_object
from gpr20_survey.plan.annotation import ANNOTATION, Annotation, annotation_of
from gpr20_survey.plan.markers import (
    FOUND_FORMAT,
    MAX_MARKERS,
    REQUEST_KEYS,
    Marker,
    found_of,
    markers_of,
)
from gpr20_survey.trace import utc_time

OF_MARKERS = (Kind.MARKER, Kind.MARKER_REMOVED)
KINDS = tuple(one.value for one in (Kind.ANNOTATION, *OF_MARKERS, Kind.REPORT, *NOTES))
OPTIONAL_KEYS = ("name", "heading_deg")
# Of an annotation: the notes that its client had read, so that none written since are lost.
NOTES_BEFORE = "notes_before"
ANNOTATION_KEYS = ("operator", "site", "notes", "position", *OPTIONAL_KEYS)


def requested_fact(kind: str, values_json: str, now: str) -> Tuple[Kind, Change]:
    """Return what a request adds to the log of a survey now, which is ISO 8601 text.

    Its kind is one of `KINDS`: the others are written by the storage alone.

    Raises:
        SurveyRefusedError: The kind is another one, or there is no such object.
        InvalidValueError: The object is not what its kind has.
    """
    check_one_of("kind", kind, KINDS)
    found = Kind(kind)
    most = MAX_REPORT_BYTES if found is Kind.REPORT else MAX_BYTES
    values = parse_object(values_json, "values_json", most)
    if found is Kind.REPORT:
        return found, lambda description: _unless_entry(description, "report", Fact(found, values))
    if found is Kind.ANNOTATION:
        # It replaces the former one: what is left out by mistake would be lost.
        before = values.pop(NOTES_BEFORE, None)
        _check_keys(kind, {**dict.fromkeys(OPTIONAL_KEYS), **values}, ANNOTATION_KEYS)
        annotation = record_from(Annotation, values, ANNOTATION)
        return found, lambda description: _unless_entry(
            description, ANNOTATION, Fact(found, _joined(annotation, before, description).values())
        )
    if found is Kind.MARKER:
        _check_keys(kind, values, REQUEST_KEYS)
        marker = record_from(Marker, values, kind)
        return found, lambda description: _new_marker(description, marker, now)
    if found is Kind.MARKER_REMOVED:
        _check_keys(kind, values, ("marker_id", "author"))
        # Which checks the values.
        gone = record_from(Marker, {**values, "x_mm": 0.0, "y_mm": 0.0}, kind)
        return found, lambda description: _removed_marker(description, gone, now)
    _check_note(found, values)
    return found, lambda _description: Fact(found, values)


def _check_note(kind: Kind, values: Dict[str, Any]) -> None:
    """Check a note, which is known by its own time when its request is repeated."""
    time = values.get("time")
    if not isinstance(time, str):
        raise SurveyRefusedError(
            Message(
                "the fact of kind {kind} has no text 'time'; say when it was, such as {example}",
                kind=kind.value,
                example=utc_time.iso_text(0),
            )
        )
    utc_time.parse_iso(time)
    # Readers leave out other formats.
    if kind is Kind.FOUND and values.get("format") == FOUND_FORMAT and found_of(values).photo:
        raise InvalidValueError(
            Message("photo must be empty; gpr20 annotate --photo stores one with its record")
        )


def _joined(annotation: Annotation, before: Any, description: Mapping[str, Any]) -> Annotation:
    """Return an annotation with what a survey has and its client does not know.

    Args:
        annotation: What the client wants.
        before: The notes that it has changed; None: it replaces them.
        description: What the survey has.
    """
    found = keeping_heading(annotation, description)
    if not isinstance(before, str):
        return found
    return replace(found, notes=joined_notes(before, found.notes, annotation_of(description).notes))


def joined_notes(before: str, wanted: str, present: str) -> str:
    """Return the notes that somebody wants, and below them what others have written meanwhile.

    Args:
        before: The notes that were changed to those that are wanted.
        wanted: Them.
        present: What the survey has now.
    """
    if present == before:
        return wanted
    if wanted in present:
        return present  # the answer to the first call may have been lost
    added = present[len(before) :] if present.startswith(before) else present
    return "\n".join(one for one in (wanted, added.strip("\n")) if one)


def keeping_heading(annotation: Annotation, description: Mapping[str, Any]) -> Annotation:
    """Return an annotation with the heading that a survey has, unless it has one itself.

    Clients that do not know a heading leave it out. It is kept as long as the position stays.
    """
    try:
        former = annotation_of(description)
    except InvalidValueError:
        return annotation  # it is replaced because it is wrong
    if annotation.heading_deg is not None or former.position != annotation.position:
        return annotation
    return replace(annotation, heading_deg=former.heading_deg)


def _new_marker(description: Dict[str, Any], marker: Marker, now: str) -> Optional[Fact]:
    present = markers_of(description)
    for one in present:
        if one.marker_id == marker.marker_id:
            if one.same_request(marker):
                return None  # the answer to the first call may have been lost
            reason = Message("another marker has the id {marker}", marker=marker.marker_id)
            raise SurveyRefusedError(reason, fault=faults.MARKER_REFUSED)
    if len(present) >= MAX_MARKERS:
        reason = Message(
            "the survey has {count} markers; write further places into its notes",
            count=len(present),
        )
        raise SurveyRefusedError(reason, fault=faults.MARKER_REFUSED)
    return Fact(Kind.MARKER, asdict(replace(marker, time=now)))


def _removed_marker(description: Dict[str, Any], gone: Marker, now: str) -> Optional[Fact]:
    former = [one for one in markers_of(description) if one.marker_id == gone.marker_id]
    if not former:
        reason = Message("the survey has no marker {marker}", marker=gone.marker_id)
        raise SurveyRefusedError(reason, fault=faults.MARKER_REFUSED)
    change = {"marker_id": gone.marker_id, "removed": now, "removed_by": gone.author}
    return Fact(Kind.MARKER_REMOVED, change) if former[0].is_present else None


def _unless_entry(description: Dict[str, Any], key: str, fact: Fact) -> Optional[Fact]:
    """Return a fact that replaces an entry of the description; None if it is that entry already."""
    return None if description.get(key) == fact.values else fact


def _check_keys(kind: str, values: Dict[str, Any], keys: Collection[str]) -> None:
    if set(values) != set(keys):
        raise InvalidValueError(
            Message(
                "{name} must be an object with the keys {keys}", name=kind, keys=", ".join(keys)
            )
        )


def check_one_of(place: str, value: str, allowed: Collection[str]) -> None:
    """Check a word of a request; SurveyRefusedError: it is not one of those allowed."""
    if value not in allowed:
        raise SurveyRefusedError(
            Message(
                "{place} is {value}; it must be one of {allowed}",
                place=place,
                value=repr(value[:64]),
                allowed=", ".join(allowed),
            )
        )
