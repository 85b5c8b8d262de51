"""A picture that a finger moves, zooms and touches; sections and the view from above are such."""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import numpy as np
from PyQt5.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPolygonF,
    QResizeEvent,
    QTransform,
    QWheelEvent,
)
from PyQt5.QtWidgets import QGestureEvent, QPinchGesture, QSizePolicy, QWidget

from gpr20_operator.ground.sources import Picture
from gpr20_operator.ground.texts import GroundMark
from gpr20_operator.palette import shade_colours, shade_numbers
from gpr20_user_interface.look.look import Look, Mark, look_of
from gpr20_user_interface.look.translation import shown_number
from gpr20_user_interface.widgets.ink import (
    Ticks,
    paint_axes,
    paint_mark,
    paint_notice,
    round_ticks,
    stroke,
)

# A finger that moved less than this has touched a place.
SLOP_PX = 12
# How far from a mark a finger may be.
REACH_PX = 24
# A second touch within this time is a bounced one, not a double tap.
BOUNCE_MS = 60
MOST_ZOOM = 40.0
WHEEL_ZOOM = 1.25
# Half of the gap in the middle of the crosshair: what lies under it stays free.
FREE_PX = 14.0
# Room of a number on each axis.
TICK_PX = (60, 44)
# What numbers take that stand beside a picture: left, above, right and below.
BESIDE_PX = (44, 22, 18, 24)
UNIT = QRectF(0.0, 0.0, 1.0, 1.0)


def extent_of(picture: Picture) -> QRectF:
    """Return the outer edges of a picture, in units of its axes."""
    (left, right), (low, high) = picture.across_mm, picture.range
    return QRectF(left, low, right - left, high - low)


def image_of(numbers: np.ndarray, colours: np.ndarray) -> QImage:
    """Return a picture of numbers, each of which has a colour (uint8, n x 4)."""
    pixels = colours[numbers]
    height, width = numbers.shape
    image = QImage(pixels.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888)
    # Its own memory, in the one format that Qt enlarges fast.
    return image.convertToFormat(QImage.Format.Format_ARGB32_Premultiplied)


class Plot(QWidget):
    """Draws a Picture, with what lies below and above it; both axes have numbers.

    Args:
        to_scale: Both axes have the same scale.
        downwards: The second axis points down.
        scrubs: A finger moves the crosshair instead of the picture.
        interactive: Whether it takes touches.
        beside: The numbers stand beside the picture, else on it.

    Attributes:
        extent: What is shown at first, in units of the axes; None: nothing is known.
        numbers: What is drawn: 0..254 for shades, 255 for what is not there; None: no picture.
        marks: What is marked.
        crosshair: Where the crosshair is on each axis; None: nowhere.
        notice: What is written over the picture.
        labels: Titles of both axes.
    """

    # Values of both axes, at a touch; while a finger moves, only if it scrubs.
    touched = pyqtSignal(float, float)
    dragged = pyqtSignal(float, float)
    double_tapped = pyqtSignal()
    pressed = pyqtSignal()

    def __init__(
        self,
        to_scale: bool = False,
        downwards: bool = False,
        scrubs: bool = False,
        interactive: bool = True,
        beside: bool = False,
    ) -> None:
        super().__init__()
        self._to_scale, self._downwards, self._scrubs = to_scale, downwards, scrubs
        self._beside = beside
        # The picture, the lowest value of both axes first, and where it lies on them.
        self._image, self._image_area = QImage(), QRectF()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(1, 1)
        if interactive:
            self.grabGesture(Qt.GestureType.PinchGesture)
        else:
            self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.extent: Optional[QRectF] = None
        self.numbers: Optional[np.ndarray] = None
        self.marks: Tuple[GroundMark, ...] = ()
        self.crosshair: Tuple[Optional[float], Optional[float]] = (None, None)
        self.notice, self.labels = "", ("", "")
        self._zoom, self._centre = 1.0, QPointF()
        self._pressed: Optional[QPointF] = None
        self._finger: Optional[QPointF] = None
        self._pressed_ms = 0
        self._place()

    def show_picture(self, picture: Optional[Picture]) -> None:
        """Draw a picture; None: nothing."""
        self.numbers = None
        if picture is not None and picture.measured:
            self.numbers = shade_numbers(picture.shades)
            image = image_of(self.numbers, shade_colours())
            # The rows of an image go downwards.
            self._image = image if self._downwards else image.mirrored()
            self._image_area = extent_of(picture)
        self.update()

    def set_extent(self, extent: Optional[QRectF]) -> None:
        """Show all of another part of the axes; the same one stays zoomed as it is."""
        if extent != self.extent:
            self.extent = extent
            self.show_all()

    def set_marks(self, marks: Sequence[GroundMark]) -> None:
        """Mark places; later ones are painted over earlier ones."""
        self.marks = tuple(marks)
        self.update()

    def set_crosshair(self, across: Optional[float], second: Optional[float]) -> None:
        """Mark a place on each axis; None: nowhere."""
        self.crosshair = (across, second)
        self.update()

    def set_notice(self, notice: str) -> None:
        """Write over the picture; empty: nothing."""
        self.notice = notice
        self.update()

    def show_all(self) -> None:
        """Show everything again after moving and zooming."""
        self._zoom, self._centre = 1.0, (self.extent or UNIT).center()
        self._place()

    def centre_on(self, across: float, second: float) -> None:
        """Bring a place to the middle, as far as there is something around it."""
        self._centre = QPointF(across, second)
        self._place()

    def zoom_by(self, factor: float, around: QPointF) -> None:
        """Zoom; the place below a pixel stays there."""
        place = self.to_data(around)
        self._zoom = min(max(self._zoom * factor, 1.0), MOST_ZOOM)
        self._place()
        self._pull(self.to_screen(*place), around)

    @property
    def area(self) -> QRectF:
        """The picture on the screen, without what lies beside it."""
        whole = QRectF() if self.extent is None else self._map.mapRect(self.extent)
        return whole & self._room()

    def to_screen(self, across: float, second: float) -> QPointF:
        """Return the pixel of a place."""
        return self._map.map(QPointF(across, second))

    def pixels_of(self, place: QRectF) -> QRectF:
        """Return the pixels of a rectangle of places."""
        return self._map.mapRect(place)

    def to_data(self, pixel: QPointF) -> Tuple[float, float]:
        """Return the place of a pixel."""
        place = self._back.map(pixel)
        return place.x(), place.y()

    @property
    def _frame(self) -> QRectF:
        """Where there is something to measure, on the screen."""
        return self.area

    def _room(self) -> QRectF:
        """Return what the picture may fill."""
        if not self._beside:
            return QRectF(self.rect())
        left, above, right, below = map(look_of(self).px, BESIDE_PX)
        return QRectF(self.rect().adjusted(left, above, -right, -below))

    def _pull(self, before: QPointF, after: QPointF) -> None:
        """Move what is below one pixel to another one."""
        (x, y), (new_x, new_y) = self.to_data(before), self.to_data(after)
        self.centre_on(self._centre.x() + x - new_x, self._centre.y() + y - new_y)

    def _place(self) -> None:
        """Show what zoom and centre say, within the extent."""
        extent, room = self.extent or UNIT, self._room()
        x_px = self._zoom * max(room.width(), 1) / max(extent.width(), 1e-9)
        y_px = self._zoom * max(room.height(), 1) / max(extent.height(), 1e-9)
        if self._to_scale:
            x_px = y_px = min(x_px, y_px)
        half_x, half_y = room.width() / x_px / 2.0, room.height() / y_px / 2.0
        x = _within(self._centre.x(), extent.left(), extent.right(), half_x)
        y = _within(self._centre.y(), extent.top(), extent.bottom(), half_y)
        self._centre = QPointF(x, y)
        down_px = y_px if self._downwards else -y_px
        left_px, top_px = room.center().x() - x * x_px, room.center().y() - y * down_px
        self._map = QTransform(x_px, 0.0, 0.0, down_px, left_px, top_px)
        self._back = self._map.inverted()[0]
        self.update()

    def resizeEvent(self, _event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: it has another size."""
        self._place()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger comes."""
        if event.button() == Qt.MouseButton.LeftButton and self.extent is not None:
            self._pressed = self._finger = event.localPos()
            self._pressed_ms = event.timestamp()
            self.pressed.emit()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger comes again soon."""
        if event.timestamp() - self._pressed_ms >= BOUNCE_MS:
            self._pressed = None
            self.double_tapped.emit()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger moves."""
        place, before = event.localPos(), self._finger
        slop_px = look_of(self).px(SLOP_PX)
        if before is None:
            return
        if self._pressed is not None and QLineF(place, self._pressed).length() < slop_px:
            return
        self._pressed, self._finger = None, place
        if self._scrubs:
            self.dragged.emit(*self.to_data(place))
        else:
            self._pull(before, place)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger leaves; outside of the plot it was taken away by the touch filter."""
        pressed, self._pressed, self._finger = self._pressed, None, None
        if pressed is not None and self.rect().contains(event.pos()):
            self._touch(pressed)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the wheel turns."""
        up = event.angleDelta().y() > 0
        self.zoom_by(WHEEL_ZOOM if up else 1.0 / WHEEL_ZOOM, event.posF())

    def event(self, event: QEvent) -> bool:
        """Qt: two fingers move."""
        if event.type() == QEvent.Type.Gesture and isinstance(event, QGestureEvent):
            pinch = event.gesture(Qt.GestureType.PinchGesture)
            if isinstance(pinch, QPinchGesture):
                self._pressed = self._finger = None
                last, now = pinch.lastCenterPoint().toPoint(), pinch.centerPoint().toPoint()
                now_px = QPointF(self.mapFromGlobal(now))
                self._pull(QPointF(self.mapFromGlobal(last)), now_px)
                self.zoom_by(pinch.scaleFactor(), now_px)
                event.accept(pinch)
                return True
        return bool(super().event(event))

    def _touch(self, place: QPointF) -> None:
        self.touched.emit(*self.to_data(place))

    def marks_near(self, place: QPointF) -> List[GroundMark]:
        """Return the marks within reach of a finger, the nearest first."""
        found = [
            (QLineF(self.to_screen(one.across_mm, one.second_mm), place).length(), one)
            for one in self.marks
        ]
        # Whichever of them is chosen, and with that painted last, the order is the same.
        found.sort(key=lambda pair: (pair[0], len(pair[1].text), pair[1].text))
        return [one for px, one in found if px <= look_of(self).px(REACH_PX)]

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        painter, look = QPainter(self), look_of(self)
        painter.fillRect(self.rect(), QColor(look.colour(Mark.PAPER)))
        painter.setClipRect(self._room().adjusted(-1, -1, 1, 1))
        self._paint_below(painter, look)
        if self.numbers is not None:
            painter.drawImage(self.pixels_of(self._image_area), self._image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.extent is not None:
            self._paint_above(painter, look)
            self._paint_crosshair(painter, look)
            # A ring at the edge is seen as a whole.
            painter.setClipping(False)
            for one in self.marks:
                paint_mark(painter, look, one, self.to_screen(one.across_mm, one.second_mm))
            paint_axes(painter, look, self.area, self.labels, self._ticks(look), self._beside)
        if self.notice:
            paint_notice(painter, look, QRectF(self.rect()), self.notice)

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        """Draw below the picture, in pixels."""

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        """Draw above the picture and below marks, in pixels."""

    def _paint_crosshair(self, painter: QPainter, look: Look) -> None:
        across, second = self.crosshair
        here, frame = self.to_screen(across or 0.0, second or 0.0), self._frame
        free_px = look.px(FREE_PX) if across is not None and second is not None else 0
        x, y, lines = here.x(), here.y(), []
        if across is not None:
            lines += [(x, frame.top(), x, y - free_px), (x, y + free_px, x, frame.bottom())]
        if second is not None:
            lines += [(frame.left(), y, x - free_px, y), (x + free_px, y, frame.right(), y)]
        # Upright and level lines look the same without it, and are drawn many times faster.
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        for x, y, to_x, to_y in lines:
            stroke(painter, look, Mark.SELECTED, QPolygonF([QPointF(x, y), QPointF(to_x, to_y)]))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def _ticks(self, look: Look) -> Tuple[Ticks, Ticks]:
        """Return the numbers of both axes, with their pixels."""
        area, (x_px, y_px) = self.area, TICK_PX
        (left, one), (right, other) = self.to_data(area.topLeft()), self.to_data(area.bottomRight())
        xs = round_ticks(left, right, max(2, int(area.width() / look.px(x_px))))
        low, high = min(one, other), max(one, other)
        ys = round_ticks(low, high, max(2, int(area.height() / look.px(y_px))))
        return (
            [(self.to_screen(x, 0.0).x(), shown_number(x)) for x in xs.tolist()],
            [(self.to_screen(0.0, y).y(), shown_number(y)) for y in ys.tolist()],
        )


def _within(centre: float, low: float, high: float, half: float) -> float:
    """Return the nearest centre from which nothing beyond both ends is seen."""
    half = min(half, (high - low) / 2.0)
    return min(max(centre, low + half), high - half)
