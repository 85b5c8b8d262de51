"""Candidates and the operator's markers in the pictures of RADAR."""

from __future__ import annotations

from typing import List, Optional, Protocol, Sequence

from gpr20_user_interface.mid.focused_image import CandidateMark
from gpr20_user_interface.mid.radar_records import Axis, Place
from gpr20_user_interface.views.palette import Mark
from gpr20_user_interface.views.picture_plot import Spot

# What is nearer than this to a slice or line lies in it.
NEAR_MM = 25.0


class Marked(Protocol):
    """A candidate, or a marker of the operator.

    Attributes:
        number: What is written beside it.
        x_mm: X.
        y_mm: Y.
        depth_mm: Below the surface; None: at any depth.
    """

    @property
    def number(self) -> int:
        """What is written beside it."""

    @property
    def x_mm(self) -> float:
        """X [mm]."""

    @property
    def y_mm(self) -> float:
        """Y [mm]."""

    @property
    def depth_mm(self) -> Optional[float]:
        """Depth below the surface [mm]; None: not known."""


def slice_spots(marked: Sequence[Marked], depth_m: float) -> List[Spot]:
    """Return what is marked in the slice at a depth."""
    return [
        Spot(
            one.x_mm,
            one.y_mm,
            str(one.number),
            _mark(one),
            one.depth_mm is None or abs(one.depth_mm - depth_m * 1000.0) <= NEAR_MM,
        )
        for one in marked
    ]


def line_spots(marked: Sequence[Marked], place: Place, along: Axis) -> List[Spot]:
    """Return what is marked in the line through a place; what is far from it is left out."""
    spots = []
    for one in marked:
        if along is Axis.X_MM:
            away_mm, across_mm = one.y_mm - place.y_mm, one.x_mm
        else:
            away_mm, across_mm = one.x_mm - place.x_mm, one.y_mm
        if abs(away_mm) <= NEAR_MM and one.depth_mm is not None:
            spots.append(Spot(across_mm, one.depth_mm, str(one.number), _mark(one)))
    return spots


def _mark(one: Marked) -> Mark:
    return Mark.CANDIDATE if isinstance(one, CandidateMark) else Mark.MARKER
