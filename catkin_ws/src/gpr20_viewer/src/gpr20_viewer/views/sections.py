"""B-scan, section and slice through one place."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
import pyqtgraph
from PyQt5.QtCore import QObject, QRectF, Qt, pyqtSignal

from gpr20_analysis.dataset import MM_PER_M, X, Y
from gpr20_analysis.errors import AnalysisError
from gpr20_common.message import Message
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_viewer.live_image import NS_PER_S
from gpr20_viewer.picks import Picks
from gpr20_viewer.pictures import (
    longest_delay_s,
    section_picture,
    slice_picture,
    traces_picture,
)
from gpr20_viewer.positions import Line, Place
from gpr20_viewer.scene import Mark, Scene
from gpr20_viewer.views.colours import CANDIDATE, HIDDEN, HYPERBOLA, NO_DATA, SURFACE
from gpr20_viewer.views.picture_plot import CANDIDATE_ANCHOR, Marks, PicturePlot


class BScanView(PicturePlot):
    """A B-scan; the delay grows downwards.

    Attributes:
        hyperbola: The curve of delays that an echo of the cursor's place has.
        surface: The curve of delays of the surface, by the recorded heights.
    """

    def __init__(self) -> None:
        super().__init__(downwards=True, to_scale=False)
        pen = pyqtgraph.mkPen(HYPERBOLA, width=2, style=Qt.PenStyle.DashLine)
        self.hyperbola = pyqtgraph.PlotCurveItem(pen=pen)
        self.surface = pyqtgraph.PlotCurveItem(pen=pyqtgraph.mkPen(SURFACE, width=1))
        for curve in (self.surface, self.hyperbola):
            self.addItem(curve, ignoreBounds=True)

    def show_hyperbola(
        self, line: Line, place: Place, permittivity: float, separation_m: float
    ) -> None:
        """Draw the delays of an echo from a place, and those of the surface."""
        across_mm = line.position_m * MM_PER_M
        delays_s = line.delays_s(place, permittivity, separation_m)
        self.hyperbola.setData(across_mm, delays_s * NS_PER_S)
        surface_s = line.surface_delays_s(separation_m)
        self.surface.setData(across_mm, surface_s * NS_PER_S)
        at_m = place.x_m if line.along == "x" else place.y_m
        at_ns = float(np.interp(at_m, line.position_m, delays_s)) * NS_PER_S
        self.show_cursor(at_m * MM_PER_M, at_ns)


class SliceView(PicturePlot):
    """A C-scan, true to scale.

    Attributes:
        candidates: Marks of candidates.
        without_data: Marks of positions without data.
        hidden: Where a mine could hide.
    """

    def __init__(self) -> None:
        super().__init__(downwards=False, to_scale=True)
        self.candidates = Marks(self, "d", CANDIDATE, CANDIDATE_ANCHOR)
        self.without_data = Marks(self, "x", NO_DATA)
        self.hidden = pyqtgraph.ImageItem(axisOrder="row-major")
        self.hidden.setZValue(1.0)
        self.addItem(self.hidden, ignoreBounds=True)

    def show_hidden(self, found: Optional[HidingMap], depth_m: float) -> None:
        """Cover with grey where a target as deep as that could hide."""
        if found is None:
            return
        colours = np.zeros((*found.missed_m.shape, 4), np.uint8)
        # Without a depth it was found at all of them.
        colours[found.missed_m <= depth_m] = HIDDEN
        self.hidden.setImage(colours, levels=(0, 255))
        self.hidden.setRect(QRectF(*_extent_mm(found)))

    def show_without_data(self, places_m: np.ndarray) -> None:
        """Mark the positions (x, y) without data."""
        self.without_data.show([Mark(x * MM_PER_M, y * MM_PER_M) for x, y in places_m])


def _extent_mm(found: HidingMap) -> Tuple[float, float, float, float]:
    """Return left, top, width and height of a map."""
    width_m, height_m = found.cell_m
    return (
        MM_PER_M * (float(found.x_m[0]) - width_m / 2.0),
        MM_PER_M * (float(found.y_m[0]) - height_m / 2.0),
        MM_PER_M * width_m * len(found.x_m),
        MM_PER_M * height_m * len(found.y_m),
    )


class SectionView(PicturePlot):
    """A section; the depth grows downwards.

    Attributes:
        candidates: Marks of candidates.
    """

    def __init__(self) -> None:
        super().__init__(downwards=True, to_scale=False)
        self.candidates = Marks(self, "d", CANDIDATE, CANDIDATE_ANCHOR)


class Sections(QObject):
    """Draws a scene in three plots.

    Attributes:
        placed: A click: the place.
        hovered: The mouse is there: the place.
        b_scan: The traces of the line.
        section: The image below the line.
        slice: The image at one depth.
        problem: Why the traces cannot be drawn; None: they are.
    """

    placed = pyqtSignal(object)
    hovered = pyqtSignal(object)

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self._scene = scene
        self.b_scan, self.section, self.slice = BScanView(), SectionView(), SliceView()
        self.problem: Optional[Message] = None
        self._drawn: Optional[Tuple[object, ...]] = None
        self._connect(self.b_scan, "in_traces")
        self._connect(self.section, "in_section")
        self._connect(self.slice, "in_slice")

    @property
    def plots(self) -> Tuple[PicturePlot, ...]:
        """The three plots."""
        return self.b_scan, self.section, self.slice

    def show_scene(self, scene: Scene, background: bool, picks: Picks) -> None:
        """Draw a scene.

        Args:
            scene: The scene.
            background: Whether the background is subtracted from the B-scan.
            picks: The picks.
        """
        self._scene = scene
        display, place, image = scene.display, scene.place, scene.image
        self._draw_traces(scene, background)
        self.b_scan.show_hyperbola(scene.line, place, scene.permittivity, scene.separation_m)
        section = level = None
        if image is not None:
            other_m, gain = scene.other_of(place), display.db_per_ns
            section = section_picture(image, display.turn, display.along, other_m, gain)
            level = slice_picture(image, display.turn, place.depth_m, gain)
        self.section.show_picture(section, display.range_db)
        self.slice.show_picture(level, display.range_db)
        self.slice.show_hidden(scene.session.hiding, place.depth_m)
        self.slice.show_without_data(scene.session.without_data(display.turn))
        self.section.show_cursor(scene.along_of(place) * MM_PER_M, place.depth_m * MM_PER_M)
        self.slice.show_cursor(place.x_m * MM_PER_M, place.y_m * MM_PER_M)
        self.show_marks(picks)
        self._show_titles(scene)

    def show_marks(self, picks: Picks) -> None:
        """Draw the marks of picks and candidates."""
        for plot, marks in zip(self.plots, self._scene.pick_marks(picks)):
            plot.picks.show(marks)
        in_section, in_slice = self._scene.candidate_marks()
        self.section.candidates.show(in_section)
        self.slice.candidates.show(in_slice)

    def show_all(self) -> None:
        """Show the whole pictures again after panning and zooming."""
        for plot in self.plots:
            plot.show_all()

    def _connect(self, plot: PicturePlot, function: str) -> None:
        def place(across: float, down: float) -> object:
            return getattr(self._scene, function)(across, down)

        plot.placed.connect(lambda across, down: self.placed.emit(place(across, down)))
        plot.hovered.connect(lambda across, down: self.hovered.emit(place(across, down)))

    def _draw_traces(self, scene: Scene, background: bool) -> None:
        display, line = scene.display, scene.line
        until_s = longest_delay_s(line, scene.deepest_m, scene.permittivity, scene.separation_m)
        key = (display, background, line.other_m, until_s)
        if key == self._drawn:
            return
        self._drawn, self.problem, picture = key, None, None
        try:
            picture = traces_picture(
                scene.session, line, display.turn, background, until_s, display.db_per_ns
            )
        except AnalysisError as error:
            self.problem = error.message
        self.b_scan.show_picture(picture, display.range_db)

    def _show_titles(self, scene: Scene) -> None:
        along, place = scene.display.along, scene.place
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
