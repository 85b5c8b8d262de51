"""Where on the screen a place of the survey area is, and the other way round."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np


@dataclass(frozen=True)
class MapGeometry:
    """The survey area in a widget, to scale, X to the right and Y up.

    Args:
        left_mm: Left edge of the area.
        bottom_mm: Lower edge of the area.
        width_mm: Width of the area.
        height_mm: Height of the area.
        left_px: Where the left edge is drawn.
        bottom_px: Where the lower edge is drawn.
        px_per_mm: Scale, the same in both directions.
    """

    left_mm: float
    bottom_mm: float
    width_mm: float
    height_mm: float
    left_px: float
    bottom_px: float
    px_per_mm: float

    def to_screen(self, x_mm: float, y_mm: float) -> Tuple[float, float]:
        """Return where a place is drawn [px]."""
        return (
            self.left_px + (x_mm - self.left_mm) * self.px_per_mm,
            self.bottom_px - (y_mm - self.bottom_mm) * self.px_per_mm,
        )

    def to_ground(self, x_px: float, y_px: float) -> Tuple[float, float]:
        """Return the place that is drawn there [mm]."""
        return (
            self.left_mm + (x_px - self.left_px) / self.px_per_mm,
            self.bottom_mm + (self.bottom_px - y_px) / self.px_per_mm,
        )

    def clamped(self, x_mm: float, y_mm: float) -> Tuple[float, float, bool]:
        """Return the nearest place in the area, and whether that is the place itself."""
        x = min(max(x_mm, self.left_mm), self.left_mm + self.width_mm)
        y = min(max(y_mm, self.bottom_mm), self.bottom_mm + self.height_mm)
        return x, y, (x, y) == (x_mm, y_mm)


def fit(
    xs_mm: np.ndarray, ys_mm: np.ndarray, screen_px: Tuple[float, float, float, float]
) -> MapGeometry:
    """Return the largest drawing of the stops, each with its share of the ground around it.

    Args:
        xs_mm: Columns, evenly spaced.
        ys_mm: Rows, evenly spaced.
        screen_px: Left, top, width and height of the room for it.
    """
    left_mm, width_mm = _span(xs_mm)
    bottom_mm, height_mm = _span(ys_mm)
    left_px, top_px, room_width_px, room_height_px = screen_px
    scale = max(min(room_width_px / width_mm, room_height_px / height_mm), 1e-6)
    return MapGeometry(
        left_mm,
        bottom_mm,
        width_mm,
        height_mm,
        left_px + (room_width_px - width_mm * scale) / 2.0,
        top_px + (room_height_px + height_mm * scale) / 2.0,
        scale,
    )


def _span(places_mm: np.ndarray) -> Tuple[float, float]:
    spacing_mm = abs(places_mm[1] - places_mm[0])
    lowest_mm, highest_mm = float(places_mm.min()), float(places_mm.max())
    return lowest_mm - spacing_mm / 2.0, highest_mm - lowest_mm + spacing_mm
