"""A picture with a cursor and marks, on which a click names a place."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple

import pyqtgraph
from PyQt5.QtCore import QRectF, Qt, pyqtSignal

from gpr20_viewer.pictures import Picture
from gpr20_viewer.scene import Mark

INK, PAPER, CURSOR = "#111111", "w", "#d94801"
# No colour of the level scale, which runs from violet over green to yellow.
NOT_MEASURED = (140, 140, 140)
AXIS_WIDTH_PX, MARK_PX = 46, 12
CELL_WITHOUT_NEIGHBOUR_MM = 10.0


class Marks:
    """Marks of one kind in a plot.

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
        self._plot, self._colour, self._anchor = plot, colour, anchor
        self._points = pyqtgraph.ScatterPlotItem(
            symbol=symbol, size=MARK_PX, pen=pyqtgraph.mkPen(colour, width=2), brush=None
        )
        self._texts: List[pyqtgraph.TextItem] = []
        plot.addItem(self._points, ignoreBounds=True)

    def show(self, marks: Sequence[Mark]) -> None:
        """Draw these marks instead of the former ones."""
        self._points.setData([one.across for one in marks], [one.down for one in marks])
        for text in self._texts:
            self._plot.removeItem(text)
        self._texts = []
        for one in marks:
            text = pyqtgraph.TextItem(one.name, color=self._colour, anchor=self._anchor)
            text.setPos(one.across, one.down)
            self._plot.addItem(text, ignoreBounds=True)
            self._texts.append(text)

    @property
    def count(self) -> int:
        """Number of marks that are drawn."""
        return len(self._points.data)


class PicturePlot(pyqtgraph.PlotWidget):
    """Draws a picture; what was not measured is grey.

    Attributes:
        placed: A click: place across and down.
        image: The picture.
        cursor: Its two lines, across and down.
    """

    placed = pyqtSignal(float, float)

    def __init__(self, downwards: bool, to_scale: bool = False) -> None:
        super().__init__(background=PAPER)
        self.setMenuEnabled(False)
        self.getViewBox().setDefaultPadding(0.0)
        self.getViewBox().invertY(downwards)
        self.getViewBox().setBackgroundColor(NOT_MEASURED)
        self.setAspectLocked(to_scale)
        for name in ("left", "bottom"):
            axis = self.getAxis(name)
            axis.setPen(INK)
            axis.setTextPen(INK)
            axis.enableAutoSIPrefix(False)
        self.getAxis("left").setWidth(AXIS_WIDTH_PX)
        self.setMinimumSize(160, 140)
        self.image = pyqtgraph.ImageItem(axisOrder="row-major")
        self.addItem(self.image)
        pen = pyqtgraph.mkPen(CURSOR, width=1)
        self.cursor = [pyqtgraph.InfiniteLine(angle=one, pen=pen) for one in (90, 0)]
        for line in self.cursor:
            self.addItem(line, ignoreBounds=True)
        self.scene().sigMouseClicked.connect(self._clicked)

    def set_texts(self, title: str, across: str, down: str) -> None:
        """Write the title and beside the axes."""
        self.setTitle(title, color=INK, size="9pt")
        for name, text in (("bottom", across), ("left", down)):
            self.setLabel(name, text, **{"font-size": "8pt", "color": INK})

    def show_picture(self, picture: Optional[Picture]) -> None:
        """Draw a picture; None: nothing."""
        if picture is None or picture.levels_db.size == 0:
            self.image.clear()
            return
        # It draws nothing for NaN.
        self.image.setImage(picture.levels_db, autoLevels=False)
        rows, columns = picture.levels_db.shape
        left, width = _cells(picture.across, columns)
        top, height = _cells(picture.down, rows)
        self.image.setRect(QRectF(left, top, width, height))

    def show_cursor(self, across: float, down: float) -> None:
        """Draw the cursor at a place."""
        for line, value in zip(self.cursor, (across, down)):
            line.setValue(value)

    def _clicked(self, event: Any) -> None:
        at = self.image.mapFromScene(event.scenePos())
        inside = self.image.image is not None and self.image.boundingRect().contains(at)
        if event.button() == Qt.MouseButton.LeftButton and inside:
            place = self.getViewBox().mapSceneToView(event.scenePos())
            self.placed.emit(place.x(), place.y())


def _cells(ends: Tuple[float, float], count: int) -> Tuple[float, float]:
    """Return where the cells around even places begin, and the length of all."""
    first, last = ends
    step = (last - first) / (count - 1) if count > 1 else CELL_WITHOUT_NEIGHBOUR_MM
    return first - step / 2.0, step * count
