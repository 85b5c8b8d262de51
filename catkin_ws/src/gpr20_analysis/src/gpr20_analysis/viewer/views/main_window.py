"""The window of the viewer: one place in the ground, shown by all views."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, List, Optional

import numpy as np
from PyQt5.QtGui import QCloseEvent
from PyQt5.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMessageBox,
    QSizePolicy,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from gpr20_analysis.dataset import MM_PER_M, X, Y
from gpr20_analysis.viewer.live_image import (
    NS_PER_S,
    ImageRequest,
    LiveImage,
    PermittivitySource,
)
from gpr20_analysis.viewer.pictures import (
    longest_delay_s,
    section_picture,
    slice_picture,
    traces_picture,
)
from gpr20_analysis.viewer.positions import Line, Place
from gpr20_analysis.viewer.session import ASSUMED_PERMITTIVITY, ViewSession
from gpr20_analysis.viewer.views.b_scan_view import BScanView
from gpr20_analysis.viewer.views.candidates_table import CandidatesTable
from gpr20_analysis.viewer.views.colour_scale import ColourScale
from gpr20_analysis.viewer.views.controls import Controls
from gpr20_analysis.viewer.views.lists import KeysList, NotesList
from gpr20_analysis.viewer.views.live_bridge import LiveBridge
from gpr20_analysis.viewer.views.pick_desk import PickDesk
from gpr20_analysis.viewer.views.picture_plot import Mark, PicturePlot
from gpr20_analysis.viewer.views.section_view import SectionView
from gpr20_analysis.viewer.views.shortcuts import add_shortcuts
from gpr20_analysis.viewer.views.slice_view import SliceView
from gpr20_analysis.viewer.views.status_bar import StatusBar
from gpr20_analysis.viewer.views.volume_view import new_volume_view
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message

RANGE_DB = 40.0
SIZE_PX = (1360, 820)
SIDE_PX = 430
SINGLE_STEP_M = 0.005


class MainWindow(QMainWindow):
    """Shows a survey from all sides.

    Args:
        session: The survey.
        desk: Its picks.
        name: What the survey is called in the title.
        catalogue: Language of the texts.
        flat: Whether to show projections instead of 3D.
        ask: Asks the analyst a question; returns whether the answer is yes.

    Attributes:
        place: The place of the cursor.
        image: The image that is shown; None: there is none yet.
        is_computing: Whether an image with the present settings is being computed.
    """

    def __init__(
        self,
        session: ViewSession,
        desk: PickDesk,
        name: str,
        catalogue: Catalogue,
        flat: bool = False,
        ask: Optional[Callable[[str], bool]] = None,
    ) -> None:
        super().__init__()
        self.session, self.desk, self._catalogue = session, desk, catalogue
        self._ask = ask or self._ask_in_dialog
        self.place = session.middle()
        self.image: Optional[LiveImage] = None
        self.is_computing = True
        self._problem: Optional[Message] = None
        first = session.first_request
        self._wanted = first
        title = catalogue.tr("GPR-20 survey {name}", name=name)
        simulated = catalogue.tr("SIMULATED")
        self.setWindowTitle(f"{title} · {simulated}" if session.simulated else title)
        self.status = StatusBar(session.simulated, catalogue)
        self.b_scan, self.section, self.slice = BScanView(), SectionView(), SliceView()
        self.volume = new_volume_view(catalogue, flat)
        self.controls = Controls(
            catalogue, session.rotations_deg, first.deepest_m, first.background, RANGE_DB
        )
        self.controls.show_permittivity(first.permittivity or ASSUMED_PERMITTIVITY)
        self.click_picks = QCheckBox(catalogue.tr("a click picks"))
        self.candidates = CandidatesTable(catalogue)
        self.notes = NotesList(catalogue)
        self.scale = ColourScale(catalogue)
        self.cursor_text, self.mouse_text = QLabel(), QLabel()
        self._drawn_line: Optional[tuple] = None
        self._lay_out()
        self._connect()
        self.bridge = LiveBridge(session)
        self.bridge.computed.connect(self._show_computed)
        self.bridge.failed.connect(self._show_failed)
        self.bridge.request(first)
        self._refresh()

    @property
    def line(self) -> Line:
        """The line of traces that the B-scan shows."""
        display = self.controls.display
        at_m = self.place.y_m if display.along == X else self.place.x_m
        return self.session.line(display.turn, display.along, at_m)

    def move_to(self, place: Place) -> None:
        """Put the cursor at a place; outside of the survey, at its edge."""
        x_m, y_m = (self.session.axis_m(axis) for axis in (X, Y))
        self.place = Place(
            float(np.clip(place.x_m, x_m.min(), x_m.max())),
            float(np.clip(place.y_m, y_m.min(), y_m.max())),
            float(np.clip(place.depth_m, 0.0, self.controls.deepest_m)),
        )
        self._refresh()

    def pick(self) -> None:
        """Pick the place of the cursor."""
        if self.image is None:
            return
        turn = self.controls.display.turn
        turn_deg = self.session.rotations_deg[turn]
        place = self.place
        self.desk.add(
            place,
            None if math.isnan(turn_deg) else turn_deg,
            (self.controls.permittivity, self._source_now()),
            self._level_db(place),
        )
        self._show_marks()

    def nudge(self, columns: int = 0, rows: int = 0, layers: int = 0) -> None:
        """Move the cursor by steps of the survey, and of the image downwards."""
        depth_m = SINGLE_STEP_M if self.image is None else float(self.image.depth_m[1])
        if self.image is not None:
            depth_m = float(self.image.depth_m[1] - self.image.depth_m[0])
        self.move_to(
            Place(
                self.place.x_m + columns * self._step_m(X),
                self.place.y_m + rows * self._step_m(Y),
                self.place.depth_m + layers * depth_m,
            )
        )

    def show_all(self) -> None:
        """Show the whole pictures again after panning and zooming."""
        for plot in (self.b_scan, self.section, self.slice):
            plot.show_all()

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Qt: the window is about to close."""
        question = self._catalogue.tr("The picks are NOT SAVED. Close the window and lose them?")
        if self.desk.is_unsaved and not self._ask(question):
            event.ignore()
            return
        self.bridge.close()
        super().closeEvent(event)

    def _show_computed(self, image: LiveImage) -> None:
        self.image = image
        self._problem = None
        self.is_computing = image.request != self._wanted
        if self._wanted.permittivity is None and not self.is_computing:
            # From now on the slider starts at the estimate, or at what was assumed.
            self._wanted = replace(
                self._wanted, permittivity=image.permittivity, source=image.source
            )
            self.controls.show_permittivity(image.permittivity)
        self.candidates.show_candidates(image.candidates)
        self._refresh_image()

    def _show_failed(self, request: ImageRequest, error: Exception) -> None:
        if request != self._wanted:
            return
        self.is_computing = False
        reason = Message("program error {error}", error=f"{type(error).__name__}: {error}")
        if isinstance(error, Gpr20Error):
            reason = error.message
        elif isinstance(error, MemoryError):
            reason = Message("not enough memory; use fewer samples", details=error)
        self._problem = Message("no image with these settings: {reason}", reason=reason)
        self._refresh_image()

    def _source_now(self) -> PermittivitySource:
        # Before the first image the slider shows what is assumed.
        if self._wanted.permittivity is None:
            return PermittivitySource.ASSUMED
        return self._wanted.source

    def _set_permittivity(self, permittivity: float) -> None:
        self._request(replace(
            self._wanted, permittivity=permittivity, source=PermittivitySource.SLIDER
        ))  # fmt: skip

    def _request_again(self) -> None:
        self._request(
            replace(
                self._wanted,
                background=self.controls.background.isChecked(),
                deepest_m=self.controls.deepest_m,
                candidates=self.candidates.searched.isChecked(),
            )
        )

    def _request(self, wanted: ImageRequest) -> None:
        if wanted != self._wanted:
            self._wanted, self.is_computing = wanted, True
            self.bridge.request(wanted)
        self._refresh()
        self._show_status()

    def _refresh_image(self) -> None:
        display = self.controls.display
        self.volume.show_image(self.image, display.turn, display.range_db, display.db_per_ns)
        self.scale.show_range(display.range_db)
        self.slice.show_without_data(self.session.without_data(display.turn))
        self._show_status()
        self._refresh()

    def _refresh(self) -> None:
        display, place, line = self.controls.display, self.place, self.line
        permittivity, apart_m = self.controls.permittivity, self.session.options.separation_m
        self._draw_traces(line, longest_delay_s(
            line, self.controls.deepest_m, permittivity, apart_m
        ))  # fmt: skip
        self.b_scan.show_hyperbola(line, place, permittivity, apart_m)
        section = level = None
        if self.image is not None:
            at_m = place.y_m if display.along == X else place.x_m
            section = section_picture(
                self.image, display.turn, display.along, at_m, display.db_per_ns
            )
            level = slice_picture(self.image, display.turn, place.depth_m, display.db_per_ns)
        self.section.show_picture(section, display.range_db)
        self.slice.show_picture(level, display.range_db)
        along_mm = MM_PER_M * (place.x_m if display.along == X else place.y_m)
        self.section.show_cursor(along_mm, place.depth_m * MM_PER_M)
        self.slice.show_cursor(place.x_m * MM_PER_M, place.y_m * MM_PER_M)
        self.volume.show_cursor(place)
        self._show_titles(line)
        self._show_marks()
        cursor = self._catalogue.tr("Cursor: {place}", place=self._read_out(place))
        self.cursor_text.setText(cursor)

    def _draw_traces(self, line: Line, until_s: float) -> None:
        display = self.controls.display
        background = self.controls.background.isChecked()
        key = (display, background, line.other_m, until_s)
        if key == self._drawn_line:
            return
        self._drawn_line = key
        try:
            picture = traces_picture(
                self.session, line, display.turn, background, until_s, display.db_per_ns
            )
        except Gpr20Error as error:
            # The image says the same of these settings.
            self._problem = Message("no image with these settings: {reason}", reason=error.message)
            picture = None
        self.b_scan.show_picture(picture, display.range_db)

    def _show_status(self) -> None:
        tr, image = self._catalogue.tr, self.image
        if image is None:
            caption = tr("no image yet")
        else:
            caption = tr("Image: {caption}", caption=image.caption)
        if self.is_computing and self._wanted.permittivity is None:
            caption += " · " + tr("computing, the permittivity is being estimated ...")
        elif self.is_computing:
            caption += " · " + tr(
                "computing for permittivity {permittivity:.3g} ...",
                permittivity=self._wanted.permittivity,
            )
        if self.controls.display.db_per_ns > 0.0:
            gain = self.controls.display.db_per_ns
            caption += " · " + tr("display gain {gain:g} dB/ns", gain=gain)
        self.status.caption.setText(caption)
        self.status.show_problem([] if self._problem is None else [self._problem])
        remarks = [] if image is None else list(image.remarks)
        notes = [*remarks, *self.session.notes, *self.desk.notes]
        self.status.show_notes(notes)
        self.notes.show_notes(notes)

    def _show_titles(self, line: Line) -> None:
        tr, along = self._catalogue.tr, line.along
        other = Y if along == X else X
        self.b_scan.set_texts(
            tr("B-scan along {axis} at {other} {position_mm:g} mm", axis=along, other=other,
               position_mm=round(line.other_m * MM_PER_M, 2)),
            f"{along} [mm]", tr("two-way delay [ns]"),
        )  # fmt: skip
        at_m = self.place.y_m if along == X else self.place.x_m
        self.section.set_texts(
            tr("Image along {axis} at {other} {position_mm:.0f} mm", axis=along, other=other,
               position_mm=at_m * MM_PER_M),
            f"{along} [mm]", tr("depth [mm]"),
        )  # fmt: skip
        self.slice.set_texts(
            tr("Slice at depth {depth:.0f} mm", depth=self.place.depth_m * MM_PER_M),
            "x [mm]", "y [mm]",
        )  # fmt: skip

    def _show_marks(self) -> None:
        display = self.controls.display
        along = display.along
        now = self.controls.permittivity if self.image is None else self.image.permittivity
        turn_deg = self.session.rotations_deg[display.turn]
        flat, upright, in_time = [], [], []
        line = self.line
        for one in self.desk.editor.picks:
            if one.polarization_deg not in (None, turn_deg):
                continue
            flat.append(Mark(one.x_m * MM_PER_M, one.y_m * MM_PER_M, one.id))
            at_m, other_m = (one.x_m, one.y_m) if along == X else (one.y_m, one.x_m)
            if abs(other_m - line.other_m) > self._step_m(Y if along == X else X):
                continue
            # The same delay is another depth at another permittivity.
            depth_m = one.depth_m * math.sqrt(one.permittivity / now)
            upright.append(Mark(at_m * MM_PER_M, depth_m * MM_PER_M, one.id))
            place = Place(one.x_m, one.y_m, one.depth_m)
            delays_s = line.delays_s(place, one.permittivity, self.session.options.separation_m)
            at_ns = float(np.interp(at_m, line.position_m, delays_s)) * NS_PER_S
            in_time.append(Mark(at_m * MM_PER_M, at_ns, one.id))
        self.slice.picks.show(flat)
        self.section.picks.show(upright)
        self.b_scan.picks.show(in_time)
        found = None if self.image is None else self.image.candidates
        listed = () if found is None else found.candidates
        self.slice.candidates.show(
            [Mark(one.x_m * MM_PER_M, one.y_m * MM_PER_M, one.id) for one in listed]
        )

    def _read_out(self, place: Place) -> Message:
        line = self.line
        apart_m = self.session.options.separation_m
        delays_s = line.delays_s(place, self.controls.permittivity, apart_m)
        at_m = place.x_m if line.along == X else place.y_m
        delay_ns = NS_PER_S * float(np.interp(at_m, line.position_m, delays_s))
        level_db = self._level_db(place)
        return Message(
            "x {x_mm:.0f} mm, y {y_mm:.0f} mm, depth {depth_mm:.0f} mm, delay {delay_ns:.2f} ns, "
            "level {level} dB",
            x_mm=place.x_m * MM_PER_M,
            y_mm=place.y_m * MM_PER_M,
            depth_mm=place.depth_m * MM_PER_M,
            delay_ns=delay_ns,
            level="-" if level_db is None else f"{level_db:.1f}",
        )

    def _level_db(self, place: Place) -> Optional[float]:
        # The level belongs to the image that is shown, whatever the slider says meanwhile.
        if self.image is None:
            return None
        turn = self.controls.display.turn
        return self.image.level_at_db(turn, place.x_m, place.y_m, place.depth_m)

    def _place_in(self, plot: PicturePlot, across: float, down: float) -> Place:
        display, place = self.controls.display, self.place
        across_m, down_m = across / MM_PER_M, down / MM_PER_M
        if plot is self.slice:
            return Place(across_m, down_m, place.depth_m)
        if plot is self.b_scan:
            down_m = self.line.depth_m(
                across_m, down / NS_PER_S, self.controls.permittivity,
                self.session.options.separation_m, self.controls.deepest_m,
            )  # fmt: skip
        if display.along == X:
            return Place(across_m, place.y_m, down_m)
        return Place(place.x_m, across_m, down_m)

    def _placed(self, plot: PicturePlot, across: float, down: float) -> None:
        self.move_to(self._place_in(plot, across, down))
        if self.click_picks.isChecked():
            self.pick()

    def _hovered(self, plot: PicturePlot, across: float, down: float) -> None:
        place = self._read_out(self._place_in(plot, across, down))
        self.mouse_text.setText(self._catalogue.tr("Mouse: {place}", place=place))

    def _go_to_pick(self, name: str) -> None:
        for one in self.desk.editor.picks:
            if one.id == name:
                self.move_to(Place(one.x_m, one.y_m, one.depth_m))

    def _go_to_candidate(self, name: str) -> None:
        found = None if self.image is None else self.image.candidates
        for one in () if found is None else found.candidates:
            if one.id == name:
                self.move_to(Place(one.x_m, one.y_m, one.depth_m))

    def _step_m(self, axis: str) -> float:
        places_m = self.session.axis_m(axis)
        return float(np.min(np.diff(places_m))) if len(places_m) > 1 else SINGLE_STEP_M

    def _ask_in_dialog(self, question: str) -> bool:
        answer = QMessageBox.question(self, self.windowTitle(), question)
        return bool(answer == QMessageBox.StandardButton.Yes)

    def _connect(self) -> None:
        plots: List[PicturePlot] = [self.b_scan, self.section, self.slice]
        for plot in plots:
            plot.placed.connect(lambda across, down, on=plot: self._placed(on, across, down))
            plot.hovered.connect(lambda across, down, on=plot: self._hovered(on, across, down))
        self.controls.permittivity_changed.connect(self._set_permittivity)
        self.controls.image_changed.connect(self._request_again)
        self.controls.display_changed.connect(self._refresh_image)
        self.candidates.searched.toggled.connect(lambda _on: self._request_again())
        self.candidates.chosen.connect(self._go_to_candidate)
        self.desk.table.chosen.connect(self._go_to_pick)
        self.desk.table.pick_button.clicked.connect(lambda: self.pick())
        self.desk.changed.connect(self._show_marks)
        add_shortcuts(self)

    def _lay_out(self) -> None:
        tr = self._catalogue.tr
        views = QGridLayout()
        views.setSpacing(4)
        views.addWidget(self.b_scan, 0, 0)
        views.addWidget(self.slice, 0, 1)
        views.addWidget(self.section, 1, 0)
        views.addWidget(self.volume, 1, 1)
        for view in (self.b_scan, self.slice, self.section, self.volume):
            # All get the same space, whatever they would like.
            view.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        for index in (0, 1):
            views.setColumnStretch(index, 1)
            views.setRowStretch(index, 1)
        tabs = QTabWidget()
        tabs.addTab(self.desk.table, tr("Picks"))
        if self.session.find_candidates is not None:
            tabs.addTab(self.candidates, tr("Candidates"))
        tabs.addTab(self.notes, tr("Notes"))
        tabs.addTab(KeysList(self._catalogue), tr("Keys"))
        side = QWidget()
        side.setFixedWidth(SIDE_PX)
        column = QVBoxLayout(side)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.controls)
        column.addWidget(self.scale)
        column.addWidget(self.click_picks)
        column.addWidget(tabs, 1)
        middle = QHBoxLayout()
        middle.addLayout(views, 1)
        middle.addWidget(side)
        bottom = QHBoxLayout()
        bottom.addWidget(self.cursor_text, 1)
        bottom.addWidget(self.mouse_text, 1)
        central = QWidget()
        layout = QVBoxLayout(central)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addWidget(self.status)
        layout.addLayout(middle, 1)
        layout.addLayout(bottom)
        self.setCentralWidget(central)
        self.resize(*SIZE_PX)
