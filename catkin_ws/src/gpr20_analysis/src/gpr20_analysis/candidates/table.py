"""Candidates and markers of a survey as rows and lines of text; markers also as files."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import xarray as xr

from gpr20_analysis.candidates.files import write_list
from gpr20_analysis.dataset import MM_PER_M, description_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.survey_attributes import area_position
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, numeral
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.results.candidates import (
    NO_CLEARANCE,
    SIMULATED,
    AreaPosition,
    Candidate,
    CandidateList,
)
from gpr20_survey.trace.utc_time import moment_text

X_COLUMN, Y_COLUMN, RATIO_COLUMN = 1, 2, 6
WEAKER_TITLE = Message("Weaker echoes: no stronger than clutter, but weak bodies look the same:")
NONE = "-"
MARKERS_FORMAT = "gpr20-markers/1"
MARKER_COLUMNS = (
    *("id", "x_m", "y_m", "depth_m", "text", "author", "time"),
    *("longitude_deg", "latitude_deg"),
)


def candidate_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of candidates."""
    return (
        catalogue.tr("id"),
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("strength"),
        catalogue.tr("above clutter dB"),
        catalogue.tr("polarization ratio dB"),
        catalogue.tr("details"),
    )


def candidate_row(candidate: Candidate, catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return a candidate as a row of a table below `candidate_heading`."""
    ratio_db = candidate.polarization_ratio_db
    return (
        candidate.id,
        *candidate.place_texts,
        catalogue.text(candidate.strength),
        catalogue.text(numeral(candidate.above_clutter_db, ".1f")),
        NONE if ratio_db is None else catalogue.text(numeral(round(ratio_db, 1) + 0.0, "+.1f")),
        ", ".join(catalogue.text(label) for label in candidate.labels) or NONE,
    )


def candidate_table(
    found: CandidateList, listed: Sequence[Candidate], catalogue: Catalogue = ENGLISH
) -> List[Tuple[str, ...]]:
    """Return heading and rows, without columns that are empty for all, or the same on a line."""
    empty = set()
    if all(one.polarization_ratio_db is None for one in listed):
        empty.add(RATIO_COLUMN)
    if found.length_m is not None:
        # Across a line a place is less certain, and the same for all.
        along_x = all(one.y_uncertainty_m >= one.x_uncertainty_m for one in listed)
        empty.add(Y_COLUMN if along_x else X_COLUMN)
    rows = [candidate_heading(catalogue), *(candidate_row(one, catalogue) for one in listed)]
    return [tuple(cell for at, cell in enumerate(row) if at not in empty) for row in rows]


def places_sentence(found: CandidateList) -> Message:
    """Return how many places there are to check, and where the list is cut."""
    extent = Message("area {area_m2:.3g} m2", area_m2=found.area_m2)
    if found.length_m is not None:
        extent = Message("length {length_m:.3g} m", length_m=found.length_m)
    return Message(
        "Places to check: {count} ({extent}). The list is cut at {least_db:.1f} dB above clutter, "
        "where ground without bodies has about {density:.2g} places per m2.",
        count=found.primary,
        extent=extent,
        least_db=found.least_db,
        density=found.false_alarms_per_m2,
    )


def weaker_sentence(found: CandidateList) -> Message:
    """Return how many echoes are below the cut."""
    return Message("{count} weaker echoes", count=found.weaker)


def candidate_lines(
    found: CandidateList, catalogue: Catalogue = ENGLISH, weaker: bool = False
) -> List[str]:
    """Return a list of candidates as lines of text, without the notes on the survey.

    Args:
        found: The list.
        catalogue: Language of the text.
        weaker: Whether the weaker echoes are listed too.
    """
    listed = found.candidates if weaker else found.shown()
    lines = text_lines(candidate_table(found, listed, catalogue), 0) if listed else []
    if found.primary < len(listed):
        lines.insert(1 + found.primary, catalogue.text(WEAKER_TITLE))
    elif found.weaker and not weaker:
        more = Message("{echoes}; show them with --weaker", echoes=weaker_sentence(found))
        lines.append(catalogue.text(more))
    first = [SIMULATED] if found.simulated else []
    head = [*first, NO_CLEARANCE, places_sentence(found)]
    return [*(catalogue.text(one) for one in head), *lines]


def text_lines(rows: Sequence[Sequence[str]], left: int) -> List[str]:
    """Return the rows of a table as lines of text.

    Args:
        rows: The rows, which are equally long.
        left: From this column on cells are at the left; 0: only the last one.
    """
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    left = left or len(widths) - 1
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if at >= left else cell.rjust(width)
            for at, (cell, width) in enumerate(zip(row, widths))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


@dataclass(frozen=True)
class MarkerList:
    """The markers of a survey, in the order in which they were made.

    Attributes:
        survey_id: UUID; empty if it is not known.
        simulated: Whether the survey shows no real ground.
        markers: The markers that were not removed.
        position: Where the area is on the earth; None if position or heading is not known.
    """

    survey_id: str
    simulated: bool
    markers: Tuple[Marker, ...]
    position: Optional[AreaPosition] = None


def survey_markers(survey: xr.Dataset) -> MarkerList:
    """Return the markers of a survey that were not removed.

    A recording or a folder of JSON files alone holds none: they are in the log.

    Args:
        survey: Dataset of a survey.

    Raises:
        AnalysisError: The markers in the log are damaged.
    """
    try:
        return marker_list(description_of(survey), area_position(survey.attrs))
    except InvalidValueError as error:
        raise AnalysisError(error.message) from error


def marker_list(description: Mapping[str, Any], position: Optional[AreaPosition]) -> MarkerList:
    """Return the markers in what describes a survey, and where its area is.

    Raises:
        InvalidValueError: They are damaged.
    """
    survey_id, simulated = description.get("survey_id", ""), description.get("simulated")
    return MarkerList(str(survey_id), bool(simulated), present_markers(description), position)


def write_markers(found: MarkerList, path: Union[str, Path]) -> None:
    """Write markers in the format of the path's ending, and its checksum.

    Args:
        found: The markers.
        path: The file; its ending is .csv, .json or .geojson.

    Raises:
        AnalysisError: The ending is unknown, or the output cannot be written.
    """
    write_list(Path(path), _marker_head(found), "markers", _records(found), MARKER_COLUMNS)


def _marker_head(found: MarkerList) -> Dict[str, Any]:
    return {
        "format": MARKERS_FORMAT,
        "warning": str(NO_CLEARANCE),
        "simulated": found.simulated,
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        "survey_id": found.survey_id,
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "position": asdict(found.position) if found.position else None,
    }


def _records(found: MarkerList) -> List[Dict[str, Any]]:
    return [_marker_record(one, found) for one in found.markers]


def _marker_record(marker: Marker, found: MarkerList) -> Dict[str, Any]:
    x_m, y_m = marker.x_mm / MM_PER_M, marker.y_mm / MM_PER_M
    longitude_deg, latitude_deg = (
        found.position.on_earth(x_m, y_m) if found.position else (None, None)
    )
    depth_mm = marker.depth_mm
    return {
        "id": marker.marker_id,
        "x_m": round(x_m, 6),
        "y_m": round(y_m, 6),
        "depth_m": None if depth_mm is None else round(depth_mm / MM_PER_M, 6),
        "text": marker.text,
        "author": marker.author,
        "time": marker.time,
        "longitude_deg": longitude_deg,
        "latitude_deg": latitude_deg,
    }


def marker_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of markers."""
    return (
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("time"),
        catalogue.tr("operator"),
        catalogue.tr("marker"),
    )


def marker_rows(found: MarkerList, catalogue: Catalogue = ENGLISH) -> List[Tuple[str, ...]]:
    """Return the markers as rows of a table below `marker_heading`."""
    return [_marker_row(one, catalogue) for one in found.markers]


def _marker_row(marker: Marker, catalogue: Catalogue) -> Tuple[str, ...]:
    return (
        f"{marker.x_mm:.0f}",
        f"{marker.y_mm:.0f}",
        NONE if marker.depth_mm is None else f"{marker.depth_mm:.0f}",
        catalogue.text(moment_text(marker.time)),
        marker.author or NONE,
        marker.text or NONE,
    )


def marker_lines(found: MarkerList, catalogue: Catalogue = ENGLISH) -> List[str]:
    """Return a list of markers as lines of text."""
    if not found.markers:
        return [catalogue.tr("The survey has no markers.")]
    return text_lines([marker_heading(catalogue), *marker_rows(found, catalogue)], 3)
