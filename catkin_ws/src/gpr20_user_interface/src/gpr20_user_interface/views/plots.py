"""Plots that a finger cannot drag away, black on white for sunlight."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
import pyqtgraph
from PyQt5.QtCore import QRectF
from PyQt5.QtGui import QFont

from gpr20_user_interface.mid.radar_pictures import Axis, Curve, Picture
from gpr20_user_interface.views.palette import PALETTES, Mark, Theme

# How far below the strongest level a curve, and the darkest colour of a picture, ends.
CURVE_RANGE_DB = 60.0
PICTURE_RANGE_DB = 40.0
# The plots are black on white in both themes.
MARKS = PALETTES[Theme.SUN].marks
INK = MARKS[Mark.INK]
LEVELS = 255
# No colour of the level scale, which runs from violet over green to yellow.
NOT_MEASURED = (140, 140, 140)
AXIS_WIDTH_PX = 48
TICK_FONT_PX = 11


class FixedPlot(pyqtgraph.PlotWidget):
    """A plot with a title and two axes; the second one may point down.

    Attributes:
        has_numbers: Whether the axes have numbers.
    """

    def __init__(self) -> None:
        super().__init__(background="w")
        self._title = ""
        self._labels = ("", "")
        self.has_numbers = True
        self.setMouseEnabled(False, False)
        self.setMenuEnabled(False)
        self.hideButtons()
        tick_font = QFont()
        tick_font.setPixelSize(TICK_FONT_PX)
        for name in ("left", "bottom"):
            axis = self.getAxis(name)
            axis.setPen(INK)
            axis.setTextPen(INK)
            axis.enableAutoSIPrefix(False)
            axis.setTickFont(tick_font)
        self.getAxis("left").setWidth(AXIS_WIDTH_PX)
        self.setMinimumSize(120, 120)
        self._surface = pyqtgraph.InfiniteLine(
            0.0, angle=0, pen=PALETTES[Theme.SUN].marks[Mark.SURFACE]
        )
        self.addItem(self._surface, ignoreBounds=True)
        self.show_numbers(False)

    @property
    def title_text(self) -> str:
        """What is written above the plot."""
        return self._title

    def set_title(self, text: str) -> None:
        """Write above the plot."""
        # Laying out a plot costs more than drawing it.
        if text != self._title:
            self._title = text
            self.setTitle(text, color=INK, size="10pt")

    def set_labels(self, bottom: str, left: str) -> None:
        """Write beside the axes."""
        if (bottom, left) == self._labels:
            return
        self._labels = (bottom, left)
        for name, text in (("bottom", bottom), ("left", left)):
            self.setLabel(name, text, **{"font-size": f"{TICK_FONT_PX}px", "color": INK})

    def show_numbers(self, shown: bool) -> None:
        """Write numbers on the axes; those of a plot without data would be made up."""
        if shown != self.has_numbers:
            self.has_numbers = shown
            for name in ("left", "bottom"):
                self.getAxis(name).setStyle(showValues=shown)

    def show_axis(self, axis: Axis) -> None:
        """Let the second axis be delay, depth or Y; depth has a line at the surface."""
        downwards = axis is not Axis.Y_MM
        self._surface.setVisible(axis is Axis.DEPTH_MM)
        if self.getViewBox().yInverted() != downwards:
            self.getViewBox().invertY(downwards)


class CurvePlot(FixedPlot):
    """An A-scan, from the top downwards."""

    def __init__(self) -> None:
        super().__init__()
        self._curve = self.plot(pen=pyqtgraph.mkPen(MARKS[Mark.CURVE], width=2))

    @property
    def points(self) -> Tuple[np.ndarray, np.ndarray]:
        """Levels and places that are drawn."""
        levels, places = self._curve.getData()
        nothing = np.zeros(0)
        return (nothing, nothing) if levels is None else (levels, places)

    def show_curve(self, curve: Optional[Curve], in_db: bool) -> None:
        """Draw a trace; None: nothing."""
        if curve is None or not np.isfinite(curve.levels).any():
            self._curve.setData([], [])
            self.show_numbers(False)
            return
        self.show_numbers(True)
        self.show_axis(curve.axis)
        known = np.isfinite(curve.levels)
        self._curve.setData(curve.levels[known], curve.places[known])
        lowest, highest = level_range(curve.levels, CURVE_RANGE_DB if in_db else None)
        self.setXRange(lowest, highest, padding=0.02)
        self.setYRange(float(curve.places[0]), float(curve.places[-1]), padding=0.0)


class PicturePlot(FixedPlot):
    """A B- or C-scan; what was not measured is grey.

    Attributes:
        shown_range: The levels of the darkest and the brightest colour.
    """

    def __init__(self, true_to_scale: bool) -> None:
        super().__init__()
        self.setAspectLocked(true_to_scale)
        self._image = pyqtgraph.ImageItem(axisOrder="row-major")
        self._image.setLookupTable(level_colours())
        self.addItem(self._image)
        self._image.setZValue(-1)
        self.shown_range = (0.0, 0.0)

    @property
    def colour_numbers(self) -> Optional[np.ndarray]:
        """What is drawn: 0..254 for levels, 255 for what was not measured."""
        return self._image.image

    def show_picture(self, picture: Optional[Picture], in_db: bool) -> None:
        """Draw a picture; None: nothing."""
        if picture is None or not picture.measured:
            self._image.clear()
            self.show_numbers(False)
            return
        self.show_numbers(True)
        self.show_axis(picture.axis)
        self.shown_range = level_range(picture.levels, PICTURE_RANGE_DB if in_db else None)
        numbers = colour_numbers(picture.levels, self.shown_range)
        self._image.setImage(numbers, levels=(0, LEVELS), autoLevels=False)
        left, right = picture.x_range_mm
        low, high = picture.range
        self._image.setRect(QRectF(left, low, right - left, high - low))
        self.setRange(xRange=(left, right), yRange=(low, high), padding=0.0)


def level_colours() -> np.ndarray:
    """Return the colours of 255 levels and, last, that of what was not measured (256 x 3)."""
    scale = pyqtgraph.colormap.get("viridis").getLookupTable(nPts=LEVELS)
    return np.vstack([scale, NOT_MEASURED]).astype(np.uint8)


def level_range(levels: np.ndarray, range_db: Optional[float]) -> Tuple[float, float]:
    """Return the lowest and the highest level to show; without a range the scale is linear."""
    highest = float(np.nanmax(levels))
    lowest = 0.0 if range_db is None else highest - range_db
    return lowest, max(highest, lowest + 1e-12)


def colour_numbers(levels: np.ndarray, shown: Tuple[float, float]) -> np.ndarray:
    """Return the number of the colour of each level; 255 where nothing was measured."""
    lowest, highest = shown
    measured = np.isfinite(levels)
    part = (np.where(measured, levels, lowest) - lowest) / (highest - lowest)
    numbers = np.clip(part * (LEVELS - 1), 0, LEVELS - 1).astype(np.uint8)
    numbers[~measured] = LEVELS
    return numbers
