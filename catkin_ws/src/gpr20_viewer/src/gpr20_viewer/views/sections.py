"""B-scan, section, slice and the maximum over the depth, through one place."""

from __future__ import annotations

from typing import Any, Callable, List, Optional, Sequence, Tuple

import numpy as np
import pyqtgraph
from PyQt5.QtCore import QObject, QRectF, Qt, pyqtSignal

from gpr20_analysis.dataset import MM_PER_M, X, Y
from gpr20_analysis.errors import AnalysisError
from gpr20_common.message import Message
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_viewer.picks import Picks
from gpr20_viewer.scene import (
    Mark,
    Picture,
    Scene,
    longest_delay_s,
    section_picture,
    slice_picture,
    traces_picture,
)
from gpr20_viewer.session import NS_PER_S

INK, PAPER, CURSOR = "#111111", "w", "#d94801"
# No colour of the level scale, which runs from violet over green to yellow.
NOT_MEASURED = (140, 140, 140)
AXIS_WIDTH_PX, MARK_PX = 46, 12
CELL_WITHOUT_NEIGHBOUR_MM = 10.0
HYPERBOLA, SURFACE, PICK, CANDIDATE, NO_DATA = "#ff2d00", "#ffffff", "#ff00c8", "#ffffff", "#8f0000"
HIDDEN = (60, 60, 60, 170)
LOWEST_DB, RANGE_DB = -120.0, 40.0
SCALE_PX = 66


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


class Sections(QObject):
    """Draws a scene in four plots, with one scale of colours.

    Attributes:
        placed: A click: the place.
        b_scan: The traces of the line; the delay grows downwards.
        hyperbola: The delays that an echo of the cursor's place has, in the B-scan.
        section: The image below the line.
        slice: The image at one depth, true to scale.
        maximum: The brightest of all depths.
        scale: What the colours mean; drag its ends to change that.
        scale_view: The widget that shows it.
        pick_marks: Marks of picks in B-scan, section and slice.
        candidate_marks: Marks of candidates in section and slice.
        without_data: Marks of positions without data in the slice.
        problem: Why the traces cannot be drawn; None: they are.
    """

    placed = pyqtSignal(object)

    def __init__(self, scene: Callable[[], Scene]) -> None:
        super().__init__()
        self._scene = scene
        self.b_scan, self.section = PicturePlot(True), PicturePlot(True)
        self.slice, self.maximum = PicturePlot(False, True), PicturePlot(False, True)
        self.problem: Optional[Message] = None
        self._drawn: Optional[Tuple[object, ...]] = None
        dashed = pyqtgraph.mkPen(HYPERBOLA, width=2, style=Qt.PenStyle.DashLine)
        self.hyperbola = pyqtgraph.PlotCurveItem(pen=dashed)
        self._surface = pyqtgraph.PlotCurveItem(pen=pyqtgraph.mkPen(SURFACE, width=1))
        for curve in (self._surface, self.hyperbola):
            self.b_scan.addItem(curve, ignoreBounds=True)
        self._hidden = pyqtgraph.ImageItem(axisOrder="row-major")
        self._hidden.setZValue(1.0)
        self.slice.addItem(self._hidden, ignoreBounds=True)
        self.pick_marks = [Marks(one, "o", PICK) for one in (self.b_scan, self.section, self.slice)]
        # Their names are to the left of the mark; those of picks are to the right.
        self.candidate_marks = [
            Marks(one, "d", CANDIDATE, (1.2, 0.5)) for one in (self.section, self.slice)
        ]
        self.without_data = Marks(self.slice, "x", NO_DATA)
        self.scale = pyqtgraph.ColorBarItem(
            (-RANGE_DB, 0.0), width=14, colorMap="viridis", limits=(LOWEST_DB, 0.0), rounding=1.0,
            orientation="h", label="level [dB]; grey: not measured",
        )  # fmt: skip
        self.scale.getAxis("bottom").setTextPen(INK)
        self.scale.setImageItem([one.image for one in self.plots])
        self.scale_view = pyqtgraph.GraphicsLayoutWidget()
        self.scale_view.setBackground(None)
        self.scale_view.addItem(self.scale)
        self.scale_view.setFixedHeight(SCALE_PX)
        for plot, place in (
            (self.b_scan, Scene.in_traces),
            (self.section, Scene.in_section),
            (self.slice, Scene.in_slice),
            (self.maximum, Scene.in_slice),
        ):
            plot.placed.connect(
                lambda across, down, place=place: self.placed.emit(place(scene(), across, down))
            )

    @property
    def plots(self) -> Tuple[PicturePlot, ...]:
        """All plots."""
        return self.b_scan, self.section, self.slice, self.maximum

    def draw(self, background: bool, picks: Picks) -> None:
        """Draw the scene as it is now.

        Args:
            background: Whether the background is subtracted from the B-scan.
            picks: The picks.
        """
        scene = self._scene()
        place, image = scene.place, scene.image
        self._draw_traces(scene, background)
        section = level = brightest = None
        if image is not None:
            section = section_picture(image, scene.turn, scene.along, scene.other_of(place))
            level = slice_picture(image, scene.turn, place.depth_m)
            brightest = slice_picture(image, scene.turn, None)
        for plot, picture in zip(self.plots[1:], (section, level, brightest)):
            plot.show_picture(picture)
        if scene.session.hiding is not None:
            self._draw_hidden(scene.session.hiding, place.depth_m)
        nowhere_mm = MM_PER_M * scene.session.without_data(scene.turn)
        self.without_data.show([Mark(x_mm, y_mm) for x_mm, y_mm in nowhere_mm])
        self.section.show_cursor(scene.along_of(place) * MM_PER_M, place.depth_m * MM_PER_M)
        for plot in (self.slice, self.maximum):
            plot.show_cursor(place.x_m * MM_PER_M, place.y_m * MM_PER_M)
        self.draw_marks(picks)
        self._write_titles(scene)

    def draw_marks(self, picks: Picks) -> None:
        """Draw the marks of picks and candidates."""
        scene = self._scene()
        for drawn, marks in zip(self.pick_marks, scene.pick_marks(picks)):
            drawn.show(marks)
        for drawn, marks in zip(self.candidate_marks, scene.candidate_marks()):
            drawn.show(marks)

    def _draw_traces(self, scene: Scene, background: bool) -> None:
        line, permittivity = scene.line, scene.permittivity
        across_mm = line.position_m * MM_PER_M
        delays_s = line.delays_s(scene.place, permittivity, scene.separation_m)
        self.hyperbola.setData(across_mm, delays_s * NS_PER_S)
        surface_s = line.surface_delays_s(scene.separation_m)
        self._surface.setData(across_mm, surface_s * NS_PER_S)
        at_mm = scene.along_of(scene.place) * MM_PER_M
        self.b_scan.show_cursor(at_mm, scene.delay_ns(scene.place))
        until_s = longest_delay_s(line, scene.session.deepest_m, permittivity, scene.separation_m)
        key = (scene.turn, scene.along, background, line.other_m, until_s)
        if key == self._drawn:
            return
        self._drawn, self.problem, picture = key, None, None
        try:
            picture = traces_picture(scene.session, line, scene.turn, background, until_s)
        except AnalysisError as error:
            self.problem = error.message
        self.b_scan.show_picture(picture)

    def _draw_hidden(self, found: HidingMap, depth_m: float) -> None:
        """Cover with grey where a target as deep as that could hide."""
        colours = np.zeros((*found.missed_m.shape, 4), np.uint8)
        # Without a depth it was found at all of them.
        colours[found.missed_m <= depth_m] = HIDDEN
        self._hidden.setImage(colours, levels=(0, 255))
        width_m, height_m = found.cell_m
        extent_m = (
            float(found.x_m[0]) - width_m / 2.0,
            float(found.y_m[0]) - height_m / 2.0,
            width_m * len(found.x_m),
            height_m * len(found.y_m),
        )
        self._hidden.setRect(QRectF(*(MM_PER_M * one for one in extent_m)))

    def _write_titles(self, scene: Scene) -> None:
        along, place = scene.along, scene.place
        other = Y if along == X else X
        b_scan = f"B-scan along {along} at {other} {round(scene.line.other_m * MM_PER_M, 2):g} mm"
        section = f"Image along {along} at {other} {scene.other_of(place) * MM_PER_M:.0f} mm"
        level = f"Slice at depth {place.depth_m * MM_PER_M:.0f} mm"
        if scene.session.hiding is not None:
            hidden = scene.session.hiding.at(place.x_m, place.y_m)
            level = f"{level}; {hidden.sentence()}"
        self.b_scan.set_texts(b_scan, f"{along} [mm]", "two-way delay [ns]")
        self.section.set_texts(section, f"{along} [mm]", "depth [mm]")
        self.slice.set_texts(level, "x [mm]", "y [mm]")
        self.maximum.set_texts("Maximum of all depths", "x [mm]", "y [mm]")
