"""Areas of the ground, and how the pictures of one share the screen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Optional, Tuple

import numpy as np

# A survey is not drawn smaller than this part of the map to show all of one around it.
SMALLEST_PART = 1.0 / 2.0
# What is then shown of the ground around it, as a part of its own size on each side.
GROUND_AROUND = 0.25
# How wide a single line is drawn, as a part of its length.
LINE_PART = 0.1
# The view from above has at least and at most this part of the room.
LEAST_ABOVE, MOST_ABOVE = 0.3, 0.6


@dataclass(frozen=True)
class Area:
    """A rectangle of the ground [mm]."""

    left_mm: float
    right_mm: float
    low_mm: float
    high_mm: float

    @property
    def width_mm(self) -> float:
        return self.right_mm - self.left_mm

    @property
    def height_mm(self) -> float:
        return self.high_mm - self.low_mm

    def joined(self, other: Area) -> Area:
        return Area(
            min(self.left_mm, other.left_mm),
            max(self.right_mm, other.right_mm),
            min(self.low_mm, other.low_mm),
            max(self.high_mm, other.high_mm),
        )

    def grown(self, x_mm: float, y_mm: Optional[float] = None) -> Area:
        """Return a rectangle that is larger on each side; along Y as along X if that is None."""
        y_mm = x_mm if y_mm is None else y_mm
        return Area(
            self.left_mm - x_mm, self.right_mm + x_mm, self.low_mm - y_mm, self.high_mm + y_mm
        )

    def holds(self, x_mm: float, y_mm: float) -> bool:
        return self.left_mm <= x_mm <= self.right_mm and self.low_mm <= y_mm <= self.high_mm


def share_mm(places_mm: np.ndarray, others_mm: np.ndarray) -> float:
    """Return the size of a stop's share of the ground along one axis, given those of both [mm].

    Places are evenly spaced. That of a single line, which was imported, is a part of its length.
    """
    if len(places_mm) > 1:
        return float(abs(places_mm[1] - places_mm[0]))
    return max(LINE_PART * float(np.ptp(others_mm)), 1.0)


def survey_area(xs_mm: np.ndarray, ys_mm: np.ndarray) -> Area:
    """Return the stops of a survey, each with its share of the ground around it."""
    ends = xs_mm.min(), xs_mm.max(), ys_mm.min(), ys_mm.max()
    stops = Area(*map(float, ends))
    return stops.grown(share_mm(xs_mm, ys_mm) / 2.0, share_mm(ys_mm, xs_mm) / 2.0)


def shown_area(own: Area, around: Iterable[Area] = ()) -> Area:
    """Return what to show: a survey, and others around it if it stays large enough."""
    shown = own
    for one in around:
        shown = shown.joined(one)
    if (
        own.width_mm >= SMALLEST_PART * shown.width_mm
        and own.height_mm >= SMALLEST_PART * shown.height_mm
    ):
        return shown
    return own.grown(GROUND_AROUND * max(own.width_mm, own.height_mm))


def divided(width_mm: float, height_mm: float, width_px: int, height_px: int) -> Tuple[bool, int]:
    """Return how the view from above, true to scale, and the sections share a room.

    It is the division that leaves the least unused: whether the sections are beside the view from
    above, else below it; and its width if they are beside it, else its height [px].
    """
    shape = max(width_mm, 1e-6) / max(height_mm, 1e-6)
    found = []
    for beside, along_px, across_px, part in (
        (True, width_px, height_px, shape),
        (False, height_px, width_px, 1.0 / shape),
    ):
        wanted_px = across_px * part
        above_px = min(max(wanted_px, LEAST_ABOVE * along_px), MOST_ABOVE * along_px)
        # A picture that is narrower or wider than its room leaves some of it unused.
        unused = 1.0 - min(wanted_px, above_px) / max(wanted_px, above_px)
        found.append((unused * above_px * across_px, not beside, round(above_px)))
    _unused, below, above_px = min(found)
    return not below, above_px
