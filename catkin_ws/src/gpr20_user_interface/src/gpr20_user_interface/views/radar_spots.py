"""Candidates and the operator's markers in the pictures of RADAR."""

from __future__ import annotations

from typing import List, Sequence, Union

from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.mid.radar_records import Axis, Place
from gpr20_user_interface.views.palette import Mark
from gpr20_user_interface.views.picture_plot import Spot

# What is nearer than this to a slice or line lies in it.
NEAR_MM = 25.0

Marked = Union[Candidate, Marker]


def slice_spots(marked: Sequence[Marked], depth_m: float, every_number: bool) -> List[Spot]:
    """Return what is marked in the slice at a depth.

    Args:
        marked: Candidates and markers.
        depth_m: Of the slice.
        every_number: Whether doubtful candidates have their numbers too; in a small picture the
            numbers would cover each other.
    """
    spots = []
    for one in marked:
        is_near = one.depth_mm is None or abs(one.depth_mm - depth_m * 1000.0) <= NEAR_MM
        spots.append(_spot(one, one.x_mm, one.y_mm, is_near, every_number))
    return spots


def line_spots(
    marked: Sequence[Marked], place: Place, along: Axis, every_number: bool
) -> List[Spot]:
    """Return what is marked in the line through a place; what is far from it is left out.

    Args:
        marked: Candidates and markers.
        place: On the line.
        along: Direction of the line.
        every_number: Whether doubtful candidates have their numbers too.
    """
    spots = []
    for one in marked:
        if along is Axis.X_MM:
            away_mm, across_mm = one.y_mm - place.y_mm, one.x_mm
        else:
            away_mm, across_mm = one.x_mm - place.x_mm, one.y_mm
        if abs(away_mm) <= NEAR_MM and one.depth_mm is not None:
            spots.append(_spot(one, across_mm, one.depth_mm, True, every_number))
    return spots


def _spot(one: Marked, across: float, second: float, is_near: bool, every_number: bool) -> Spot:
    if isinstance(one, Candidate):
        number = str(one.number) if every_number or not one.is_doubtful else ""
        return Spot(across, second, number, Mark.CANDIDATE, is_near, one.is_doubtful)
    return Spot(across, second, "", Mark.MARKER, is_near)
