"""A picture that a finger moves, zooms and touches; sections and the view from above are such."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Iterator, List, Optional, Sequence, Tuple

import numpy as np
import pyqtgraph
from PyQt5.QtCore import QEvent, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QColor,
    QFont,
    QFontMetrics,
    QImage,
    QMouseEvent,
    QPainter,
    QPen,
    QPixmap,
    QPolygonF,
    QResizeEvent,
    QWheelEvent,
)
from PyQt5.QtWidgets import QGesture, QGestureEvent, QPinchGesture, QSizePolicy

from gpr20_operator.ground.records import Colours, Picture
from gpr20_user_interface.look.look import TEXT_PX, Look, Mark, look_of
from gpr20_user_interface.look.shade_colours import (
    NOTICE_GROUND,
    NOTICE_INK,
    colour_table,
    shade_numbers,
)

# A finger that moved less than this has touched a place.
SLOP_PX = 12
# How far from a mark a finger may be.
REACH_PX = 24
# A second touch within this time is a bounced one, not a double tap.
BOUNCE_MS = 60
MOST_ZOOM = 40.0
WHEEL_ZOOM = 1.25
RING_PX, FAR_PX, FLAG_PX = 14.0, 5.0, 26.0
LINE_PX, HALO_PX = 2.0, 5.0
# Half of the gap in the middle of the crosshair: what lies under it stays free.
FREE_PX = 14.0
SMALL_TEXT_PX = 14
PADDING_PX = 6
STEPS = (1.0, 2.0, 5.0, 10.0, 20.0)


class MarkKind(enum.Enum):
    """What a mark is of."""

    CANDIDATE = "candidate"
    MARKER = "marker"


@dataclass(frozen=True)
class GroundMark:
    """A ring or a flag.

    Attributes:
        across_mm: Where it is along the first axis.
        second_mm: Where it is along the second axis: Y, or the depth.
        text: Inside of the ring.
        kind: A candidate is a ring, a marker is a flag.
        doubtful: Its ring is dashed.
        chosen: It is what the operator looks at.
        measured: Whether the ground there was measured; else the ring is grey and dashed.
        near: Whether it lies at what is shown; what does not is small and has no text.
        about: What a touch of it is about.
    """

    across_mm: float
    second_mm: float
    text: str
    kind: MarkKind = MarkKind.CANDIDATE
    doubtful: bool = False
    chosen: bool = False
    measured: bool = True
    near: bool = True
    about: object = None


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Return multiples of 1, 2 or 5 times a power of ten, from `low` to `high`.

    Args:
        low: First end of the axis.
        high: Other end, larger.
        most: How many there may be, at least one.
    """
    if not (math.isfinite(high - low) and high > low):
        return np.zeros(0)
    power = 10.0 ** math.floor(math.log10((high - low) / (most + 1)))
    for factor in STEPS:
        step = factor * power
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if last - first < most:
            return np.arange(first, last + 1) * step
    return np.zeros(0)


class ShadeItem(pyqtgraph.ImageItem):
    """An image in the one format that Qt enlarges fast."""

    def render(self) -> None:
        """Make the image that is drawn, after a change."""
        super().render()
        if self.qimage is not None:
            self.qimage = self.qimage.convertToFormat(QImage.Format.Format_ARGB32_Premultiplied)


class Plot(pyqtgraph.GraphicsView):
    """Draws a Picture, with what lies below and above it; both axes have numbers inside.

    Args:
        to_scale: Both axes have the same scale.
        downwards: The second axis points down.
        scrubs: A finger moves the crosshair instead of the picture.
        interactive: Whether it takes touches.

    Attributes:
        extent: What is shown at first, in units of the axes; None: nothing is known.
        notice: What is written over the picture.
        labels: Titles of both axes.
    """

    # Values of both axes, at a touch; while a finger moves, only if it scrubs.
    touched = pyqtSignal(float, float)
    dragged = pyqtSignal(float, float)
    double_tapped = pyqtSignal()
    pressed = pyqtSignal()
    # What is shown of both axes has changed.
    moved = pyqtSignal()

    def __init__(
        self,
        to_scale: bool = False,
        downwards: bool = False,
        scrubs: bool = False,
        interactive: bool = True,
    ) -> None:
        super().__init__(background=None)
        self._to_scale, self._downwards, self._scrubs = to_scale, downwards, scrubs
        self._box = pyqtgraph.ViewBox(enableMenu=False, invertY=downwards, defaultPadding=0.0)
        self._image = ShadeItem(axisOrder="row-major")
        self._box.addItem(self._image, ignoreBounds=True)
        self.setCentralItem(self._box)
        self.centralWidget.setAcceptHoverEvents(False)
        self.setViewportUpdateMode(self.ViewportUpdateMode.FullViewportUpdate)
        self.setMouseTracking(False)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(1, 1)
        if interactive:
            self.viewport().grabGesture(Qt.GestureType.PinchGesture)
        else:
            self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.extent: Optional[QRectF] = None
        self.notice = ""
        self.labels = ("", "")
        self._numbers: Optional[np.ndarray] = None
        self._colours: Optional[Colours] = None
        self._marks: Tuple[GroundMark, ...] = ()
        self._crosshair: Tuple[Optional[float], Optional[float]] = (None, None)
        self._zoom = 1.0
        self._centre: Optional[QPointF] = None
        self._pressed: Optional[QPointF] = None
        self._pressed_ms = 0
        self._finger: Optional[QPointF] = None
        self._overlaid: Tuple[object, QPixmap] = (None, QPixmap())

    @property
    def numbers(self) -> Optional[np.ndarray]:
        """What is drawn: 0..254 for shades, 255 for what is not there; None: no picture."""
        return self._numbers

    @property
    def marks(self) -> Tuple[GroundMark, ...]:
        """What is marked."""
        return self._marks

    @property
    def crosshair(self) -> Tuple[Optional[float], Optional[float]]:
        """Where the crosshair is on each axis; None: nowhere."""
        return self._crosshair

    def show_picture(self, picture: Optional[Picture], colours: Colours) -> None:
        """Draw a picture; None: nothing.

        Args:
            picture: The picture.
            colours: Its colours; those with a sign only if it has one.
        """
        self._numbers = None
        if picture is None or not picture.measured:
            self._image.clear()
            return
        used = colours if picture.signed else Colours.ENVELOPE
        if used is not self._colours:
            self._colours = used
            self._image.setLookupTable(colour_table(used))
        self._numbers = shade_numbers(picture.shades, picture.signed)
        self._image.setImage(self._numbers, autoLevels=False)
        (left, right), (low, high) = picture.across_mm, picture.range
        self._image.setRect(QRectF(left, low, right - left, high - low))

    def set_extent(self, extent: Optional[QRectF]) -> None:
        """Show all of another part of the axes; the same one stays zoomed as it is."""
        if extent != self.extent:
            self.extent = extent
            self.show_all()

    def set_marks(self, marks: Sequence[GroundMark]) -> None:
        """Mark places; later ones are painted over earlier ones."""
        # The same ones stay the same object: then they are not painted again.
        if tuple(marks) != self._marks:
            self._marks = tuple(marks)
            self.scene().update()

    def set_crosshair(self, across: Optional[float], second: Optional[float]) -> None:
        """Mark a place on each axis; None: nowhere."""
        self._crosshair = (across, second)
        self.scene().update()

    def set_notice(self, notice: str) -> None:
        """Write over the picture; empty: nothing."""
        self.notice = notice
        self.scene().update()

    def show_all(self) -> None:
        """Show everything again after moving and zooming."""
        self._zoom, self._centre = 1.0, None
        self._place()

    def fill(self) -> None:
        """Zoom until the picture fills the room, around the crosshair."""
        if self.extent is None:
            return
        x_px, y_px = self._scale_px()
        whole = self.extent.width() * x_px, self.extent.height() * y_px
        shares = self.viewport().width() / whole[0], self.viewport().height() / whole[1]
        self._zoom *= max(shares)
        across, second = self._crosshair
        middle = self._middle()
        self.centre_on(
            middle.x() if across is None else across, middle.y() if second is None else second
        )

    def centre_on(self, across: float, second: float) -> None:
        """Bring a place to the middle, as far as there is something around it."""
        self._centre = QPointF(across, second)
        self._place()

    def zoom_by(self, factor: float, around: QPointF) -> None:
        """Zoom; the place below a pixel stays there."""
        before = self.to_data(around)
        self._zoom = min(max(self._zoom * factor, 1.0), MOST_ZOOM)
        self._centre = self._centre or self._middle()
        self._place()
        after = self.to_data(around)
        self.centre_on(
            self._centre.x() + before[0] - after[0], self._centre.y() + before[1] - after[1]
        )

    @property
    def area(self) -> QRectF:
        """The picture on the screen, without what lies beside it."""
        if self.extent is None:
            return QRectF()
        ends = [
            self.to_screen(self.extent.left(), self.extent.top()),
            self.to_screen(self.extent.right(), self.extent.bottom()),
        ]
        whole = QRectF(*ends).normalized()
        return whole & QRectF(self.viewport().rect())

    def to_screen(self, across: float, second: float) -> QPointF:
        """Return the pixel of a place."""
        x_px, y_px = self._scale_px()
        middle = self._centre or self._middle()
        down = (second - middle.y()) * y_px
        return QPointF(
            self.viewport().width() / 2.0 + (across - middle.x()) * x_px,
            self.viewport().height() / 2.0 + (down if self._downwards else -down),
        )

    def to_data(self, pixel: QPointF) -> Tuple[float, float]:
        """Return the place of a pixel."""
        x_px, y_px = self._scale_px()
        middle = self._centre or self._middle()
        down = (pixel.y() - self.viewport().height() / 2.0) / y_px
        return (
            middle.x() + (pixel.x() - self.viewport().width() / 2.0) / x_px,
            middle.y() + (down if self._downwards else -down),
        )

    def _scale_px(self) -> Tuple[float, float]:
        """Return the pixels per unit of both axes."""
        extent = self.extent or QRectF(0.0, 0.0, 1.0, 1.0)
        x_px = max(self.viewport().width(), 1) / max(extent.width(), 1e-9)
        y_px = max(self.viewport().height(), 1) / max(extent.height(), 1e-9)
        if self._to_scale:
            x_px = y_px = min(x_px, y_px)
        return x_px * self._zoom, y_px * self._zoom

    def _middle(self) -> QPointF:
        return QPointF() if self.extent is None else self.extent.center()

    def _place(self) -> None:
        """Let the box show what zoom and centre say, within the extent."""
        if self.extent is not None:
            x_px, y_px = self._scale_px()
            half_x = self.viewport().width() / x_px / 2.0
            half_y = self.viewport().height() / y_px / 2.0
            if self._centre is not None:
                self._centre = QPointF(
                    _within(self._centre.x(), self.extent.left(), self.extent.right(), half_x),
                    _within(self._centre.y(), self.extent.top(), self.extent.bottom(), half_y),
                )
            middle = self._centre or self._middle()
            shown = QRectF(middle.x() - half_x, middle.y() - half_y, 2 * half_x, 2 * half_y)
            self._box.setRange(shown, padding=0.0)
        self.resetCachedContent()
        self.scene().update()
        self.moved.emit()

    def resizeEvent(self, event: Optional[QResizeEvent]) -> None:  # noqa: N802 (Qt's name)
        """Qt: it has another size."""
        super().resizeEvent(event)
        # pyqtgraph calls this itself while it makes the view, and Qt after it was closed.
        if event is not None and not self.closed:
            self._place()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger comes."""
        if event.button() != Qt.MouseButton.LeftButton or self.extent is None:
            return
        self._pressed = self._finger = event.localPos()
        self._pressed_ms = event.timestamp()
        self._begin_drag(event.localPos())
        self.pressed.emit()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger comes again soon."""
        if event.timestamp() - self._pressed_ms >= BOUNCE_MS:
            self._pressed = None
            self.double_tapped.emit()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger moves."""
        place = event.localPos()
        if self._finger is None:
            return
        if self._pressed is not None:
            if _distance(place, self._pressed) < look_of(self).px(SLOP_PX):
                return
            self._pressed = None
        if self._scrubs:
            self.dragged.emit(*self.to_data(place))
        else:
            before, after = self.to_data(self._finger), self.to_data(place)
            middle = self._centre or self._middle()
            self.centre_on(middle.x() + before[0] - after[0], middle.y() + before[1] - after[1])
        self._finger = place

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger leaves; outside of the plot it was taken away by the touch filter."""
        pressed, self._pressed, self._finger = self._pressed, None, None
        if pressed is not None and self.viewport().rect().contains(event.pos()):
            self._touch(pressed)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the wheel turns."""
        if self.extent is not None:
            up = event.angleDelta().y() > 0
            self.zoom_by(WHEEL_ZOOM if up else 1.0 / WHEEL_ZOOM, event.posF())

    def viewportEvent(self, event: QEvent) -> bool:  # noqa: N802 (Qt's name)
        """Qt: two fingers move."""
        if event.type() == QEvent.Type.Gesture and isinstance(event, QGestureEvent):
            pinch: Optional[QGesture] = event.gesture(Qt.GestureType.PinchGesture)
            if isinstance(pinch, QPinchGesture) and self.extent is not None:
                self._pressed = self._finger = None
                self._pinch(pinch)
                event.accept(pinch)
                return True
        return bool(super().viewportEvent(event))

    def _pinch(self, pinch: QPinchGesture) -> None:
        centre = self.viewport().mapFromGlobal(pinch.centerPoint().toPoint())
        last = self.viewport().mapFromGlobal(pinch.lastCenterPoint().toPoint())
        before, after = self.to_data(QPointF(last)), self.to_data(QPointF(centre))
        middle = self._centre or self._middle()
        self.centre_on(middle.x() + before[0] - after[0], middle.y() + before[1] - after[1])
        self.zoom_by(pinch.scaleFactor(), QPointF(centre))

    def _begin_drag(self, place: QPointF) -> None:
        """Note where a finger has come."""

    def _touch(self, place: QPointF) -> None:
        self.touched.emit(*self.to_data(place))

    def marks_near(self, place: QPointF) -> List[GroundMark]:
        """Return the marks within reach of a finger, the nearest first."""
        reach_px = look_of(self).px(REACH_PX)
        found = [
            (_distance(self.to_screen(one.across_mm, one.second_mm), place), one)
            for one in self._marks
        ]
        # Whichever of them is chosen, and with that painted last, the order is the same.
        found.sort(key=lambda pair: (pair[0], len(pair[1].text), pair[1].text))
        return [one for px, one in found if px <= reach_px]

    def drawBackground(self, painter: QPainter, _rect: QRectF) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw what lies below the picture."""
        look = look_of(self)
        painter.save()
        painter.resetTransform()
        painter.fillRect(self.viewport().rect(), QColor(look.colour(Mark.PAPER)))
        self._paint_below(painter, look)
        painter.restore()

    def drawForeground(self, painter: QPainter, _rect: QRectF) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw what lies above the picture."""
        look = look_of(self)
        painter.save()
        painter.resetTransform()
        painter.setFont(self.font())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.extent is not None:
            self._paint_above(painter, look)
            self._paint_crosshair(painter, look)
            painter.drawPixmap(0, 0, self._overlay(look))
        self._paint_notice(painter, look)
        painter.restore()

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        """Draw below the picture, in pixels."""

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        """Draw above the picture and below marks, in pixels."""

    def polygon(self, across: np.ndarray, second: np.ndarray) -> QPolygonF:
        """Return the pixels of places."""
        (x_px, y_px), middle = self._scale_px(), self._centre or self._middle()
        xs = self.viewport().width() / 2.0 + (across - middle.x()) * x_px
        down = (second - middle.y()) * (y_px if self._downwards else -y_px)
        ys = self.viewport().height() / 2.0 + down
        return QPolygonF([QPointF(x, y) for x, y in zip(xs.tolist(), ys.tolist())])

    def _paint_crosshair(self, painter: QPainter, look: Look) -> None:
        across, second = self._crosshair
        room, free_px = QRectF(self.viewport().rect()), look.px(FREE_PX)
        here = self.to_screen(across or 0.0, second or 0.0)
        lines = []
        if across is not None:
            gap_px = free_px if second is not None else 0
            for ends in ((room.top(), here.y() - gap_px), (here.y() + gap_px, room.bottom())):
                lines.append(QPolygonF([QPointF(here.x(), one) for one in ends]))
        if second is not None:
            gap_px = free_px if across is not None else 0
            for ends in ((room.left(), here.x() - gap_px), (here.x() + gap_px, room.right())):
                lines.append(QPolygonF([QPointF(one, here.y()) for one in ends]))
        for line in lines:
            stroke(painter, look, Mark.SELECTED, line)

    def _paint_mark(self, painter: QPainter, look: Look, mark: GroundMark) -> None:
        place = self.to_screen(mark.across_mm, mark.second_mm)
        own = Mark.CANDIDATE if mark.kind is MarkKind.CANDIDATE else Mark.MARKER
        own = Mark.SELECTED if mark.chosen else own if mark.measured else Mark.NOT_MEASURED
        if mark.kind is MarkKind.MARKER:
            _paint_flag(painter, look, place, own, look.px(FLAG_PX if mark.near else FLAG_PX / 2))
        else:
            self._paint_ring(painter, look, mark, place, own)

    def _paint_ring(
        self, painter: QPainter, look: Look, mark: GroundMark, place: QPointF, own: Mark
    ) -> None:
        radius = look.px((RING_PX if mark.near else FAR_PX) + 3 * mark.chosen)
        paper, ink = QColor(look.colour(Mark.PAPER)), QColor(look.colour(own))
        painter.setPen(QPen(paper, look.px(HALO_PX)))
        painter.setBrush(paper if mark.near else Qt.BrushStyle.NoBrush)
        painter.drawEllipse(place, radius, radius)
        pen = QPen(ink, look.px(LINE_PX + 1))
        if mark.doubtful or not mark.measured:
            pen.setDashPattern([2.0, 1.4])
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(place, radius, radius)
        if mark.near and mark.text:
            size_px = look.px(TEXT_PX if len(mark.text) < 3 else SMALL_TEXT_PX)
            font = _sized(painter.font(), size_px, bold=True)
            box = QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius)
            text = QColor(look.colour(Mark.INK if mark.measured else Mark.NOT_MEASURED))
            _paint_text(painter, font, box, mark.text, text)

    def _overlay(self, look: Look) -> QPixmap:
        """Return marks and numbers; they are painted again only after a change."""
        size = self.viewport().size()
        ends = self.to_data(QPointF()), self.to_data(QPointF(size.width(), size.height()))
        state = (self._marks, ends, size, self.labels, look, self._axes_state())
        if state != self._overlaid[0]:
            pixmap = QPixmap(size)
            pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(pixmap)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setFont(self.font())
            for one in self._marks:
                self._paint_mark(painter, look, one)
            self._paint_axes(painter, look)
            painter.end()
            self._overlaid = state, pixmap
        return self._overlaid[1]

    def _axes_state(self) -> object:
        """Return what else the numbers depend on."""

    def _paint_axes(self, painter: QPainter, look: Look) -> None:
        """Write numbers along the lower and the left edge, inside of the picture."""
        font = _sized(painter.font(), look.px(SMALL_TEXT_PX))
        metrics, room = QFontMetrics(font), self.area
        line_px, taken = metrics.height(), []
        bottom, left = self.labels
        caption = QRectF(0, 0, metrics.horizontalAdvance(bottom) + 4, line_px)
        caption.moveBottomRight(room.bottomRight())
        if bottom:
            taken.append((caption, bottom))
        caption = QRectF(0, 0, metrics.horizontalAdvance(left) + 4, line_px)
        caption.moveTopLeft(room.topLeft())
        if left:
            taken.append((caption, left))
        for value, text in self._across_ticks(room, metrics):
            wide = metrics.horizontalAdvance(text) + 4
            x = self.to_screen(value, 0.0).x()
            box = QRectF(x - wide / 2.0, room.bottom() - line_px, wide, line_px)
            taken = _with_box(taken, box, text, room)
        for value, text in self._second_ticks(room, metrics):
            y = self.to_screen(0.0, value).y()
            wide = metrics.horizontalAdvance(text) + 4
            box = QRectF(room.left(), y - line_px / 2.0, wide, line_px)
            taken = _with_box(taken, box, text, room)
        ink, ground = QColor(look.colour(Mark.INK)), QColor(look.colour(Mark.PAPER))
        for box, text in taken:
            painter.fillRect(box, ground)
            _paint_text(painter, font, box, text, ink)

    def _across_ticks(self, room: QRectF, metrics: QFontMetrics) -> Iterator[Tuple[float, str]]:
        ends = self.to_data(room.topLeft())[0], self.to_data(room.bottomRight())[0]
        most = int(room.width() / (2.2 * max(1, metrics.horizontalAdvance("0000"))))
        return ((float(one), f"{one:g}") for one in round_ticks(*ends, max(2, most)))

    def _second_ticks(self, room: QRectF, metrics: QFontMetrics) -> Iterator[Tuple[float, str]]:
        one, other = self.to_data(room.topLeft())[1], self.to_data(room.bottomRight())[1]
        most = int(room.height() / (2.5 * max(1, metrics.height())))
        ticks = round_ticks(min(one, other), max(one, other), max(2, most))
        return ((float(one), f"{one:g}") for one in ticks)

    def _paint_notice(self, painter: QPainter, look: Look) -> None:
        if not self.notice:
            return
        padding = look.px(PADDING_PX)
        room = QRectF(self.viewport().rect()).adjusted(padding, 2 * padding, -padding, -padding)
        flags = int(Qt.AlignmentFlag.AlignHCenter | Qt.TextFlag.TextWordWrap)
        size_px = look.px(TEXT_PX)
        # Smaller letters where the sentence would be cut off.
        while True:
            painter.setFont(_sized(painter.font(), size_px))
            box = QRectF(painter.boundingRect(room, flags, self.notice))
            if size_px <= 8 or (box.height() <= room.height() and box.width() <= room.width()):
                break
            size_px -= 1
        ground = box.adjusted(-padding, -padding, padding, padding)
        painter.fillRect(ground, QColor(NOTICE_GROUND))
        painter.setPen(QColor(NOTICE_INK))
        painter.drawText(room, flags, self.notice)


def stroke(painter: QPainter, look: Look, mark: Mark, points: QPolygonF) -> None:
    """Draw a line that is seen on every shade of a picture."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in rimmed(look, mark, LINE_PX):
        painter.setPen(pen)
        painter.drawPolyline(points)


def rimmed(look: Look, mark: Mark, width: float) -> Tuple[QPen, QPen]:
    """Return the pens of a line with a rim in the colour of the paper."""
    wide = QPen(QColor(look.colour(Mark.PAPER)), look.px(width) + look.px(HALO_PX - LINE_PX))
    return wide, QPen(QColor(look.colour(mark)), look.px(width))


def _paint_flag(painter: QPainter, look: Look, foot: QPointF, mark: Mark, size: float) -> None:
    """Paint a flag whose pole has its foot at the place."""
    top = QPointF(foot.x(), foot.y() - size)
    cloth = [top, QPointF(top.x() + 0.75 * size, top.y() + 0.28 * size)]
    cloth.append(QPointF(top.x(), top.y() + 0.56 * size))
    for pen in rimmed(look, mark, LINE_PX + 1):
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.setBrush(pen.color())
        painter.drawLine(foot, top)
        painter.drawPolygon(QPolygonF(cloth))


def _paint_text(painter: QPainter, font: QFont, box: QRectF, text: str, ink: QColor) -> None:
    painter.save()
    painter.setFont(font)
    painter.setPen(ink)
    flags = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextDontClip)
    painter.drawText(box, flags, text)
    painter.restore()


def _sized(font: QFont, size_px: int, bold: bool = False) -> QFont:
    sized = QFont(font)
    sized.setPixelSize(size_px)
    sized.setBold(bold)
    return sized


Boxes = List[Tuple[QRectF, str]]


def _with_box(taken: Boxes, box: QRectF, text: str, room: QRectF) -> Boxes:
    """Return the texts with another one, if it lies inside and apart from the others."""
    inside = room.left() <= box.left() and box.right() <= room.right()
    inside = inside and room.top() <= box.top() and box.bottom() <= room.bottom()
    free = not any(one.adjusted(-2, 0, 2, 0).intersects(box) for one, _text in taken)
    return [*taken, (box, text)] if inside and free else taken


def _within(centre: float, low: float, high: float, half: float) -> float:
    """Return the nearest centre from which nothing beyond both ends is seen."""
    if 2.0 * half >= high - low:
        return (low + high) / 2.0
    return min(max(centre, low + half), high - half)


def _distance(one: QPointF, other: QPointF) -> float:
    return math.hypot(one.x() - other.x(), one.y() - other.y())
