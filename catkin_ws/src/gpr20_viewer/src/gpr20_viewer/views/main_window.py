"""The window of the viewer: one place in the ground, shown by all views."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, List, Optional, Sequence, Tuple, Union

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QCloseEvent
from PyQt5.QtWidgets import (
    QCheckBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMessageBox,
    QScrollArea,
    QSizePolicy,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_survey.radar.soils import ANY_SOIL
from gpr20_survey.results.candidates import Candidate
from gpr20_viewer.live_image import ImageRequest, LiveImage
from gpr20_viewer.picks import Pick
from gpr20_viewer.positions import Place
from gpr20_viewer.scene import Scene
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.candidates_table import CandidatesTable
from gpr20_viewer.views.colour_scale import ColourScale
from gpr20_viewer.views.controls import Controls
from gpr20_viewer.views.lists import KeysList, NotesList
from gpr20_viewer.views.live_bridge import LiveBridge
from gpr20_viewer.views.pick_desk import PickDesk
from gpr20_viewer.views.sections import Sections
from gpr20_viewer.views.shortcuts import add_shortcuts
from gpr20_viewer.views.status_bar import StatusBar
from gpr20_viewer.views.volume_view import new_volume_view

RANGE_DB = 40.0
SIZE_PX = (1360, 820)
SIDE_PX = 430


class MainWindow(QMainWindow):
    """Shows a survey from all sides.

    Args:
        session: The survey.
        desk: Its picks.
        name: What the survey is called in the title.
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
        flat: bool = False,
        ask: Optional[Callable[[str], bool]] = None,
    ) -> None:
        super().__init__()
        self.session, self.desk = session, desk
        self._ask = ask or self._ask_in_dialog
        self.place = session.middle()
        self.image: Optional[LiveImage] = None
        self.is_computing = True
        self._problem: Optional[Message] = None
        first = session.first_request
        self._wanted = self._last_request = first
        title = f"GPR-20 survey {name}"
        self.setWindowTitle(f"{title} · SIMULATED" if session.simulated else title)
        self.status = StatusBar(session.simulated)
        self.volume = new_volume_view(flat)
        self.controls = Controls(
            session.rotations_deg,
            session.axes,
            first.deepest_m,
            first.background,
            RANGE_DB,
        )
        self.controls.show_permittivity(session.options.permittivity or ANY_SOIL.permittivity)
        self.click_picks = QCheckBox("a click picks")
        self.candidates = CandidatesTable()
        self.notes = NotesList()
        self.scale = ColourScale()
        self.cursor_text, self.mouse_text = QLabel(), QLabel()
        self.sections = Sections(self.scene)
        self._lay_out()
        self._connect()
        self.bridge = LiveBridge(session)
        self.bridge.computed.connect(self._show_computed)
        self.bridge.failed.connect(self._show_failed)
        self.bridge.request(first)
        self._refresh()

    @property
    def scene(self) -> Scene:
        """What the views show."""
        controls = self.controls
        return Scene(
            self.session,
            self.image,
            self.place,
            controls.display,
            controls.permittivity,
            controls.deepest_m,
        )

    def move_to(self, place: Place) -> None:
        """Put the cursor at a place; outside of the survey, at its edge."""
        self.place = self.scene.inside(place)
        self._refresh()

    def nudge(self, columns: int = 0, rows: int = 0, layers: int = 0) -> None:
        """Move the cursor by steps of the survey, and of the image downwards."""
        self.move_to(self.scene.moved(columns, rows, layers))

    def pick(self) -> None:
        """Pick the place of the cursor, with the permittivity of the image that is shown."""
        if self.image is None or not self.image.request.same_image(self._last_request):
            # Its depth would belong to another permittivity than that of the image.
            self.desk.refuse(Message("no pick: there is no image with these settings yet"))
            return
        scene, place = self.scene, self.place
        permittivity = (self.image.permittivity, self.image.source)
        self.desk.add(place, scene.polarization_deg, permittivity, scene.level_db(place))

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Qt: the window is about to close."""
        question = "The picks are NOT SAVED. Close the window and lose them?"
        if self.desk.is_unsaved and not self._ask(question):
            event.ignore()
            return
        self.bridge.close()
        super().closeEvent(event)

    def _show_computed(self, image: LiveImage) -> None:
        self.image = image
        self._problem = None
        self.is_computing = image.request != self._last_request
        if self._wanted.permittivity is None and not self.is_computing:
            # The slider starts at the value found, or at what was assumed.
            self.controls.show_permittivity(image.permittivity)
        self.candidates.show_candidates(image.candidates)
        self._search()
        self._refresh_image()

    def _show_failed(self, request: ImageRequest, error: Exception) -> None:
        if request != self._last_request:
            return
        self.is_computing = False
        reason = Message("program error {error}", error=f"{type(error).__name__}: {error}")
        if isinstance(error, Gpr20Error):
            reason = error.message
        elif isinstance(error, MemoryError):
            reason = Message("not enough memory; use fewer samples", details=error)
        self._problem = Message("no image with these settings: {reason}", reason=reason)
        self._refresh_image()

    def _set_permittivity(self, permittivity: float) -> None:
        self._request(replace(self._wanted, permittivity=permittivity, candidates=False))

    def _request_again(self) -> None:
        self._request(
            replace(
                self._wanted,
                background=self.controls.background.isChecked(),
                deepest_m=self.controls.deepest_m,
                candidates=False,
            )
        )

    def _search(self) -> None:
        # After the image, which is not to wait for the candidates in it.
        wants = self.candidates.searched.isChecked()
        if wants and not self.is_computing and not self._last_request.candidates:
            self._request(replace(self._wanted, candidates=True))

    def _request(self, wanted: ImageRequest) -> None:
        if wanted != self._wanted:
            self._wanted = self._last_request = wanted
            self.is_computing = True
            self.bridge.request(wanted)
        self._refresh()

    def _refresh_image(self) -> None:
        display = self.controls.display
        self.volume.show_image(self.image, display.turn, display.range_db, display.db_per_ns)
        self.scale.show_range(display.range_db)
        self._refresh()

    def _refresh(self) -> None:
        scene = self.scene
        background = self.controls.background.isChecked()
        self.sections.show_scene(scene, background, self.desk.editor.picks)
        self.volume.show_cursor(self.place)
        read_out = scene.read_out(self.place)
        self.cursor_text.setText(f"Cursor: {read_out}")
        self._show_status()

    def _show_status(self) -> None:
        image = self.image
        if image is None:
            caption = "no image yet"
        else:
            caption = f"Image: {image.caption}"
        if self.is_computing and self._last_request.candidates:
            caption += " · searching candidates ..."
        elif self.is_computing:
            caption += f" · computing for permittivity {self.controls.permittivity:.3g} ..."
        if self.controls.display.db_per_ns > 0.0:
            gain = self.controls.display.db_per_ns
            caption += f" · display gain {gain:g} dB/ns"
        self.status.caption.setText(caption)
        problem = self._problem
        if problem is None and self.sections.problem is not None:
            problem = Message("no traces: {reason}", reason=self.sections.problem)
        doubts = self.session.doubts
        self.status.show_problem(doubts if problem is None else [*doubts, problem])
        remarks = [] if image is None else list(image.remarks)
        notes = [*remarks, *self.session.notes, *self.desk.notes]
        self.status.show_notes(notes)
        self.notes.show_notes(notes)

    def _placed(self, place: Place) -> None:
        self.move_to(place)
        if self.click_picks.isChecked():
            self.pick()

    def _hovered(self, place: Place) -> None:
        read_out = self.scene.read_out(place)
        self.mouse_text.setText(f"Mouse: {read_out}")

    def _go_to(self, name: str, places: Sequence[Union[Pick, Candidate]]) -> None:
        for one in places:
            if one.id == name:
                self.move_to(Place(one.x_m, one.y_m, one.depth_m))

    def _ask_in_dialog(self, question: str) -> bool:
        answer = QMessageBox.question(self, self.windowTitle(), question)
        return bool(answer == QMessageBox.StandardButton.Yes)

    def _connect(self) -> None:
        self.sections.placed.connect(self._placed)
        self.sections.hovered.connect(self._hovered)
        self.controls.permittivity_changed.connect(self._set_permittivity)
        self.controls.image_changed.connect(self._request_again)
        self.controls.display_changed.connect(self._refresh_image)
        self.candidates.searched.toggled.connect(
            lambda on: self._search() if on else self._request_again()
        )
        self.candidates.chosen.connect(lambda name: self._go_to(name, self.scene.candidates))
        self.desk.table.chosen.connect(lambda name: self._go_to(name, self.desk.editor.picks))
        self.desk.table.pick_button.clicked.connect(lambda: self.pick())
        self.desk.changed.connect(lambda: self.sections.show_marks(self.desk.editor.picks))
        add_shortcuts(self)

    def _lay_out(self) -> None:
        views = QGridLayout()
        views.setSpacing(4)
        columns: List[Tuple[QWidget, QWidget]] = [(self.sections.b_scan, self.sections.section)]
        if len(self.session.axes) > 1:
            # Below a single line there is one section, which is the whole image.
            columns.append((self.sections.slice, self.volume))
        for column, pair in enumerate(columns):
            views.setColumnStretch(column, 1)
            for row, view in enumerate(pair):
                views.setRowStretch(row, 1)
                # All get the same space, whatever they would like.
                view.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
                views.addWidget(view, row, column)
        tabs = QTabWidget()
        tabs.addTab(self.desk.table, "Picks")
        if self.session.find_candidates is not None:
            tabs.addTab(self.candidates, "Candidates")
        tabs.addTab(self.notes, "Notes")
        tabs.addTab(KeysList(), "Keys")
        settings = QWidget()
        below = QVBoxLayout(settings)
        below.setContentsMargins(0, 0, 0, 0)
        below.addWidget(self.controls)
        below.addWidget(self.scale)
        below.addWidget(self.click_picks)
        below.addWidget(tabs, 1)
        # On a low screen the settings scroll, so that the pictures are seen whole.
        side = QScrollArea()
        side.setWidget(settings)
        side.setWidgetResizable(True)
        side.setFrameShape(QFrame.Shape.NoFrame)
        side.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        bar_px = side.verticalScrollBar().sizeHint().width()
        side.setMinimumWidth(settings.minimumSizeHint().width() + bar_px)
        side.setMaximumWidth(SIDE_PX)
        middle = QHBoxLayout()
        middle.addLayout(views, 3)
        middle.addWidget(side, 2)
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
