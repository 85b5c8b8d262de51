"""Candidates and the operator's markers in the pictures of RADAR."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple, Union

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QBrush, QColor, QImage, QPainter, QPen, QPolygonF

from gpr20_operator.ground.records import Axis, Colours, Picture, Place
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.look.shade_colours import (
    NOTICE_GROUND,
    NOTICE_INK,
    shade_colours,
    shade_numbers,
)
from gpr20_user_interface.pages.ground.plots import HALO_PX, LINE_PX, FixedPlot, stroke

RING_PX, FAR_PX = 11, 4
GRIP_PX = 9
PADDING_PX = 6


@dataclass(frozen=True)
class Spot:
    """Something to mark in a picture.

    Args:
        across: Where it is along the first axis.
        second: Where it is along the second axis.
        text: What is written beside it.
        mark: Its colour; that of a marker is a flag, others are rings.
        is_near: Whether it is in this slice or line; what is not is small and has no text.
        doubtful: Whether its ring is dashed.
    """

    across: float
    second: float
    text: str
    mark: Mark
    is_near: bool = True
    doubtful: bool = False


class PicturePlot(FixedPlot):
    """A B- or C-scan; what was not measured is hatched.

    Args:
        true_to_scale: Both axes have the same scale.

    Attributes:
        notice: What is written over the picture.
        grip: Where the hyperbola can be gripped.
    """

    def __init__(self, true_to_scale: bool) -> None:
        super().__init__()
        self._true_to_scale = true_to_scale
        self._numbers: Optional[np.ndarray] = None
        self._image: Optional[QImage] = None
        self._spots: Sequence[Spot] = ()
        self._curve: Tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))
        self.grip: Optional[Tuple[float, float]] = None
        self.notice = ""

    @property
    def colour_numbers(self) -> Optional[np.ndarray]:
        """What is drawn: 0..254 for shades, 255 for what was not measured."""
        return self._numbers

    @property
    def spots(self) -> Sequence[Spot]:
        """What is marked."""
        return self._spots

    def show_picture(self, picture: Optional[Picture], colours: Colours, notice: str) -> None:
        """Draw a picture; None: nothing.

        Args:
            picture: The picture.
            colours: Its colours; those with a sign only if it has one.
            notice: What to write over it.
        """
        self.notice = notice
        self.has_numbers = picture is not None and picture.measured
        self._numbers = self._image = None
        if picture is not None and picture.measured:
            self._numbers = shade_numbers(picture.shades, picture.signed)
            self._set_axes(picture.across_mm, picture.range, picture.axis)
            used = colours if picture.signed else Colours.ENVELOPE
            self._image = self._new_image(self._numbers, used)
        self.update()

    def set_spots(self, spots: Sequence[Spot]) -> None:
        """Mark places."""
        self._spots = spots
        self.update()

    def set_hyperbola(
        self, across: np.ndarray, second: np.ndarray, apex: Optional[Tuple[float, float]]
    ) -> None:
        """Draw a curve with a grip at its apex; None: without."""
        self._curve, self.grip = (across, second), apex
        self.update()

    def area(self) -> QRectF:
        """Return the part of the widget where the data are."""
        area = super().area()
        if not (self._true_to_scale and self.has_numbers):
            return area
        width_mm, height_mm = (np.ptp(self._across), np.ptp(self._second))
        px_per_mm = min(area.width() / width_mm, area.height() / height_mm)
        size = (px_per_mm * width_mm, px_per_mm * height_mm)
        return QRectF(area.center().x() - size[0] / 2.0, area.top(), *size)

    def _new_image(self, numbers: np.ndarray, colours: Colours) -> QImage:
        pixels = np.ascontiguousarray(numbers if self.axis.downwards else numbers[::-1])
        rows, columns = pixels.shape
        image = QImage(pixels.tobytes(), columns, rows, columns, QImage.Format.Format_Indexed8)
        image.setColorTable(shade_colours(colours))
        return image.copy()  # its own memory

    def _paint_data(self, painter: QPainter, look: Look) -> None:
        area = self.area()
        if self._image is not None:
            hatch = QBrush(QColor(look.colour(Mark.NOT_MEASURED)), Qt.BrushStyle.BDiagPattern)
            painter.fillRect(area, hatch)
            painter.drawImage(area, self._image)

    def _paint_lines(self, painter: QPainter, look: Look) -> None:
        super()._paint_lines(painter, look)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.has_numbers:
            for spot in self._spots:
                self._paint_spot(painter, look, spot)
            self._paint_hyperbola(painter, look)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        self._paint_notice(painter, look)

    def _paint_spot(self, painter: QPainter, look: Look, spot: Spot) -> None:
        place = self.to_screen(spot.across, spot.second)
        size = look.px(RING_PX if spot.is_near else FAR_PX)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for colour, width in ((Mark.PAPER, HALO_PX), (spot.mark, LINE_PX)):
            dashed = spot.doubtful and colour is spot.mark
            style = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
            painter.setPen(QPen(QColor(look.colour(colour)), look.px(width), style))
            if spot.mark is Mark.MARKER:
                flag = [QPointF(0, 0), QPointF(0, -2 * size), QPointF(1.5 * size, -1.5 * size)]
                flag += [QPointF(0, -size)]
                painter.drawPolyline(QPolygonF([place + one for one in flag]))
            else:
                painter.drawEllipse(place, size, size)
        if spot.text and spot.is_near:
            metrics = painter.fontMetrics()
            beside = QPointF(place.x() + size + 3, place.y() + metrics.ascent() / 2.0)
            box = metrics.boundingRect(spot.text)
            box.translate(beside.toPoint())
            painter.fillRect(box, QColor(look.colour(Mark.PAPER)))
            painter.setPen(QColor(look.colour(spot.mark)))
            painter.drawText(beside, spot.text)

    def _paint_hyperbola(self, painter: QPainter, look: Look) -> None:
        across, second = self._curve
        if across.size:
            stroke(painter, look, Mark.CANDIDATE, self.polygon(across, second))
        if self.grip is not None:
            painter.setPen(QPen(QColor(look.colour(Mark.PAPER)), look.px(LINE_PX)))
            painter.setBrush(QColor(look.colour(Mark.CANDIDATE)))
            size = look.px(GRIP_PX)
            painter.drawEllipse(self.to_screen(*self.grip), size, size)

    def _paint_notice(self, painter: QPainter, look: Look) -> None:
        if not self.notice:
            return
        padding = look.px(PADDING_PX)
        inside = self.area().adjusted(padding, padding, -padding, -padding)
        flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        box = QRectF(painter.boundingRect(inside, flags, self.notice))
        ground = box.adjusted(-padding, -padding, padding, padding)
        painter.fillRect(ground, QColor(NOTICE_GROUND))
        painter.setPen(QColor(NOTICE_INK))
        painter.drawText(inside, flags, self.notice)


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
