"""A picture with a cursor and marks, on which a click names a place."""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import numpy as np
import pyqtgraph
from PyQt5.QtCore import QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QFont

from gpr20_viewer.pictures import Picture
from gpr20_viewer.scene import Mark
from gpr20_viewer.views.colours import (
    CURSOR,
    INK,
    LEVELS,
    PAPER,
    PICK,
    colour_numbers,
    level_colours,
)

AXIS_WIDTH_PX = 46
# To the left of the mark; names of picks are to the right.
CANDIDATE_ANCHOR = (1.2, 0.5)
MARK_PX, NAMELESS_PX = 12, 6
TICK_FONT_PX = 11
CELL_WITHOUT_NEIGHBOUR_MM = 10.0


class Marks:
    """Marks of one kind in a plot; those without a name are smaller.

    Args:
        plot: The plot.
        symbol: What they look like, as pyqtgraph names it.
        colour: Their colour.
        anchor: Where in the text of a name its place is, from 0 to 1 across and down.
    """

    def __init__(
        self,
        plot: pyqtgraph.PlotWidget,
        symbol: str,
        colour: str,
        anchor: Tuple[float, float] = (-0.2, 0.5),
    ) -> None:
        self._plot = plot
        self._colour, self._anchor = colour, anchor
        self._points = pyqtgraph.ScatterPlotItem(
            symbol=symbol, pen=pyqtgraph.mkPen(colour, width=2), brush=None
        )
        self._texts: List[pyqtgraph.TextItem] = []
        plot.addItem(self._points, ignoreBounds=True)

    def show(self, marks: Sequence[Mark]) -> None:
        """Draw these marks instead of the former ones."""
        self._points.setData(
            [one.across for one in marks],
            [one.down for one in marks],
            size=[MARK_PX if one.name else NAMELESS_PX for one in marks],
        )
        named = [one for one in marks if one.name]
        while len(self._texts) > len(named):
            self._plot.removeItem(self._texts.pop())
        while len(self._texts) < len(named):
            text = pyqtgraph.TextItem(color=self._colour, anchor=self._anchor)
            self._plot.addItem(text, ignoreBounds=True)
            self._texts.append(text)
        for text, one in zip(self._texts, named):
            text.setText(one.name)
            text.setPos(one.across, one.down)

    @property
    def count(self) -> int:
        """Number of marks that are drawn."""
        return len(self._points.data)


class PicturePlot(pyqtgraph.PlotWidget):
    """Draws a picture; what was not measured is grey.

    Attributes:
        placed: A click: place across and down.
        hovered: The mouse is there: place across and down.
        picks: Marks of picks.
    """

    placed = pyqtSignal(float, float)
    hovered = pyqtSignal(float, float)

    def __init__(self, downwards: bool, to_scale: bool) -> None:
        super().__init__(background=PAPER)
        self.setMenuEnabled(False)
        self.hideButtons()
        self.getViewBox().invertY(downwards)
        self.setAspectLocked(to_scale)
        tick_font = QFont()
        tick_font.setPixelSize(TICK_FONT_PX)
        for name in ("left", "bottom"):
            axis = self.getAxis(name)
            axis.setPen(INK)
            axis.setTextPen(INK)
            axis.enableAutoSIPrefix(False)
            axis.setTickFont(tick_font)
        self.getAxis("left").setWidth(AXIS_WIDTH_PX)
        self.setMinimumSize(160, 140)
        self._extent: Optional[QRectF] = None
        self._image = pyqtgraph.ImageItem(axisOrder="row-major")
        self._image.setLookupTable(level_colours())
        self.addItem(self._image)
        pen = pyqtgraph.mkPen(CURSOR, width=1)
        self._across = pyqtgraph.InfiniteLine(angle=90, pen=pen)
        self._down = pyqtgraph.InfiniteLine(angle=0, pen=pen)
        for line in (self._across, self._down):
            self.addItem(line, ignoreBounds=True)
        self.picks = Marks(self, "o", PICK)
        self.scene().sigMouseClicked.connect(self._clicked)
        self.scene().sigMouseMoved.connect(self._moved)

    @property
    def colours(self) -> Optional[np.ndarray]:
        """What is drawn: 0..254 for levels, 255 for what was not measured; None: nothing."""
        return self._image.image

    @property
    def cursor_place(self) -> Tuple[float, float]:
        """Where the cursor is drawn."""
        return float(self._across.value()), float(self._down.value())

    def set_texts(self, title: str, across: str, down: str) -> None:
        """Write the title and beside the axes."""
        self.setTitle(title, color=INK, size="9pt")
        for name, text in (("bottom", across), ("left", down)):
            self.setLabel(name, text, **{"font-size": "8pt", "color": INK})

    def show_picture(self, picture: Optional[Picture], range_db: float) -> None:
        """Draw a picture; None: nothing."""
        if picture is None or picture.levels_db.size == 0:
            self._image.clear()
            return
        numbers = colour_numbers(picture.levels_db, range_db)
        self._image.setImage(numbers, levels=(0, LEVELS), autoLevels=False)
        rows, columns = numbers.shape
        left, width = _cells(picture.across, columns)
        top, height = _cells(picture.down, rows)
        extent = QRectF(left, top, width, height)
        self._image.setRect(extent)
        if extent != self._extent:
            self._extent = extent
            self.show_all()

    def show_all(self) -> None:
        """Show the whole picture again after panning and zooming."""
        if self._extent is not None:
            self.setRange(self._extent, padding=0.0)

    def show_cursor(self, across: float, down: float) -> None:
        """Draw the cursor at a place."""
        self._across.setValue(across)
        self._down.setValue(down)

    def _clicked(self, event: object) -> None:
        # A bounced click is a double click; only its first half counts.
        if event.button() == Qt.MouseButton.LeftButton and not event.double():  # type: ignore[attr-defined]
            place = self._place(event.scenePos())  # type: ignore[attr-defined]
            if place is not None:
                self.placed.emit(*place)

    def _moved(self, scene_place: object) -> None:
        place = self._place(scene_place)
        if place is not None:
            self.hovered.emit(*place)

    def _place(self, scene_place: object) -> Optional[Tuple[float, float]]:
        box = self.getViewBox()
        if self._extent is None or not box.sceneBoundingRect().contains(scene_place):
            return None
        place = box.mapSceneToView(scene_place)
        return (place.x(), place.y()) if self._extent.contains(place) else None


def _cells(ends: Tuple[float, float], count: int) -> Tuple[float, float]:
    """Return where the cells around even places begin, and the length of all."""
    first, last = ends
    step = (last - first) / (count - 1) if count > 1 else CELL_WITHOUT_NEIGHBOUR_MM
    return first - step / 2.0, step * count
