"""The markers of a survey: places that people noted while it was measured or later."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import xarray as xr

from gpr20_analysis.dataset import description_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.survey_attributes import area_position
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.plan.markers import Marker, markers_of
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.trace.utc_time import moment_text

NONE = "-"


@dataclass(frozen=True)
class MarkerList:
    """The markers of a survey, in the order in which they were made.

    Attributes:
        survey_id: UUID; empty if it is not known.
        simulated: Whether the survey shows no real ground.
        markers: The markers; removed ones too, if they were requested.
        position: Where the area is on the earth; None if position or heading is not known.
    """

    survey_id: str
    simulated: bool
    markers: Tuple[Marker, ...]
    position: Optional[AreaPosition] = None


def survey_markers(survey: xr.Dataset, removed: bool = False) -> MarkerList:
    """Return the markers of a survey.

    A recording or a folder of JSON files alone holds none: they are in the log.

    Args:
        survey: Dataset of a survey.
        removed: Whether markers that were removed are listed too.

    Raises:
        AnalysisError: The markers in the log are damaged.
    """
    try:
        found = markers_of(description_of(survey))
    except InvalidValueError as error:
        raise AnalysisError(error.message) from error
    return MarkerList(
        str(survey.attrs.get("survey_id", "")),
        bool(survey.attrs.get("simulated")),
        tuple(one for one in found if removed or one.is_present),
        area_position(survey.attrs),
    )


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
    text = marker.text or NONE
    if not marker.is_present:
        text = catalogue.text(
            Message(
                "{text} (removed {time} {operator})",
                text=text,
                time=moment_text(marker.removed),
                operator=marker.removed_by,
            )
        )
    return (
        f"{marker.x_mm:.0f}",
        f"{marker.y_mm:.0f}",
        NONE if marker.depth_mm is None else f"{marker.depth_mm:.0f}",
        catalogue.text(moment_text(marker.time)),
        marker.author or NONE,
        text,
    )


def marker_lines(found: MarkerList, catalogue: Catalogue = ENGLISH) -> List[str]:
    """Return a list of markers as lines of text."""
    if not found.markers:
        return [catalogue.tr("The survey has no markers.")]
    rows = [marker_heading(catalogue), *marker_rows(found, catalogue)]
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    return [
        "  ".join(cell.rjust(width) for cell, width in zip(row[:3], widths))
        + "  "
        + "  ".join(cell.ljust(width) for cell, width in zip(row[3:-1], widths[3:]))
        + "  "
        + row[-1]
        for row in rows
    ]
