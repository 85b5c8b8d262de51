"""The markers of a survey: places that people noted while it was measured or later."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import xarray as xr

from gpr20_analysis.candidates.files import write_list
from gpr20_analysis.candidates.table import text_lines
from gpr20_analysis.dataset import MM_PER_M, description_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.survey_attributes import area_position
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED, AreaPosition
from gpr20_survey.trace.utc_time import moment_text

NONE = "-"
FORMAT = "gpr20-markers/1"
COLUMNS = (
    *("id", "x_m", "y_m", "depth_m", "text", "author", "time"),
    *("longitude_deg", "latitude_deg"),
)


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
    write_list(Path(path), _head(found), "markers", _records(found), COLUMNS)


def _head(found: MarkerList) -> Dict[str, Any]:
    return {
        "format": FORMAT,
        "warning": str(NO_CLEARANCE),
        "simulated": found.simulated,
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        "survey_id": found.survey_id,
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "position": asdict(found.position) if found.position else None,
    }


def _records(found: MarkerList) -> List[Dict[str, Any]]:
    return [_record(one, found) for one in found.markers]


def _record(marker: Marker, found: MarkerList) -> Dict[str, Any]:
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
    return [_row(one, catalogue) for one in found.markers]


def _row(marker: Marker, catalogue: Catalogue) -> Tuple[str, ...]:
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
