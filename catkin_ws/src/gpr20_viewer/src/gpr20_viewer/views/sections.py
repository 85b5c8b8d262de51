"""B-scan, section and slice through one place."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import QObject, pyqtSignal

from gpr20_analysis.dataset import MM_PER_M, X, Y
from gpr20_analysis.errors import AnalysisError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_viewer.picks import Picks
from gpr20_viewer.pictures import (
    longest_delay_s,
    section_picture,
    slice_picture,
    traces_picture,
)
from gpr20_viewer.scene import Scene
from gpr20_viewer.views.b_scan_view import BScanView
from gpr20_viewer.views.picture_plot import PicturePlot
from gpr20_viewer.views.section_view import SectionView
from gpr20_viewer.views.slice_view import SliceView


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

    def __init__(self, scene: Scene, catalogue: Catalogue) -> None:
        super().__init__()
        self._catalogue, self._scene = catalogue, scene
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
        tr, along, place = self._catalogue.tr, scene.display.along, scene.place
        other = Y if along == X else X
        b_scan = tr(
            "B-scan along {axis} at {other} {position_mm:g} mm",
            axis=along,
            other=other,
            position_mm=round(scene.line.other_m * MM_PER_M, 2),
        )
        section = tr(
            "Image along {axis} at {other} {position_mm:.0f} mm",
            axis=along,
            other=other,
            position_mm=scene.other_of(place) * MM_PER_M,
        )
        level = tr("Slice at depth {depth:.0f} mm", depth=place.depth_m * MM_PER_M)
        self.b_scan.set_texts(b_scan, f"{along} [mm]", tr("two-way delay [ns]"))
        self.section.set_texts(section, f"{along} [mm]", tr("depth [mm]"))
        self.slice.set_texts(level, "x [mm]", "y [mm]")
