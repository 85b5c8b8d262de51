"""The window of the viewer: one place in the ground, shown by all views."""

from __future__ import annotations

import signal
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, List, Optional

import pyqtgraph
from PyQt5 import sip
from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtGui import QCloseEvent, QKeySequence
from PyQt5.QtWidgets import (
    QAction,
    QApplication,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMessageBox,
    QPlainTextEdit,
    QScrollArea,
    QSizePolicy,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from gpr20_analysis.sentences import shown
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_survey.radar import ANY_SOIL
from gpr20_survey.trace.utc_time import iso_text
from gpr20_viewer.picks import Pick
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.positions import Place
from gpr20_viewer.scene import Scene
from gpr20_viewer.session import ImageRequest, LiveImage, ViewSession
from gpr20_viewer.views.live_bridge import LiveBridge
from gpr20_viewer.views.sections import Sections
from gpr20_viewer.views.settings import Settings
from gpr20_viewer.views.tables import WRONG, CandidatesTab, PicksTab

SIZE_PX, SIDE_PX = (1360, 820), 430
SIMULATED = "background: #ffd400; color: #111111; font-weight: bold; padding: 3px;"
# Python handles Ctrl-C only between its own instructions.
SIGNALS_PERIOD_MS = 200


class MainWindow(QMainWindow):
    """Shows a survey from all sides.

    Args:
        session: The survey.
        picks: Its picks.
        name: What the survey is called in the title.
        ask: Asks the analyst a question; returns whether the answer is yes.

    Attributes:
        place: The place of the cursor.
        image: The image that is shown; None: there is none yet.
        is_computing: Whether an image with the present settings is being computed.
    """

    def __init__(
        self,
        session: ViewSession,
        picks: PicksTab,
        name: str,
        ask: Optional[Callable[[str], bool]] = None,
    ) -> None:
        super().__init__()
        self.session, self.picks = session, picks
        self._ask = ask or self._ask_in_dialog
        self.place = session.middle()
        self.image: Optional[LiveImage] = None
        self.is_computing = True
        self._problem: Optional[Message] = None
        self._wanted = session.first_request
        title = f"GPR-20 survey {name}"
        self.setWindowTitle(f"{title} · SIMULATED" if session.simulated else title)
        self.settings = Settings(session.rotations_deg, session.axes, self._wanted.background)
        self.settings.show_permittivity(session.options.permittivity or ANY_SOIL.permittivity)
        self.candidates = CandidatesTab()
        self.sections = Sections(lambda: self.scene)
        self.banner = QLabel(
            "SIMULATED: the simulated robot made this survey; nothing was measured."
        )
        self.banner.setStyleSheet(SIMULATED)
        self.caption, self.problem, self.cursor_text = QLabel(), QLabel(), QLabel()
        self.problem.setStyleSheet(WRONG)
        self.problem.setWordWrap(True)
        self.notes = QPlainTextEdit()
        self.notes.setReadOnly(True)
        self._lay_out()
        self.banner.setVisible(session.simulated)
        self._connect()
        self._add_keys()
        self.bridge = LiveBridge(session)
        self.bridge.computed.connect(self._show_computed)
        self.bridge.failed.connect(self._show_failed)
        self.bridge.request(self._wanted)
        self._refresh()

    @property
    def scene(self) -> Scene:
        """What the views show."""
        settings = self.settings
        return Scene(
            self.session,
            self.image,
            self.place,
            settings.turn,
            settings.along,
            settings.permittivity,
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
        if self.image is None or self.image.request != self._wanted:
            # Its depth would belong to another permittivity than that of the image.
            reason = Message("no pick: there is no image with these settings yet")
            self.picks.say(reason, self.picks.is_unsaved)
            return
        scene, place = self.scene, self.place
        self.picks.add(
            Pick(
                "", place.x_m, place.y_m, place.depth_m, scene.polarization_deg,
                self.image.permittivity, self.image.source, scene.level_db(place),
            )
        )  # fmt: skip

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Qt: the window is about to close."""
        question = "The picks are NOT SAVED. Close the window and lose them?"
        if self.picks.is_unsaved and not self._ask(question):
            event.ignore()
            return
        self.bridge.close()
        super().closeEvent(event)

    def _show_computed(self, image: LiveImage) -> None:
        self.image = image
        self._problem = None
        self.is_computing = image.request != self._wanted
        if self._wanted.permittivity is None and not self.is_computing:
            # The slider starts at the value found, or at what was assumed.
            self.settings.show_permittivity(image.permittivity)
        self.candidates.show_candidates(image.candidates)
        self._refresh()

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
        self._refresh()

    def _request(self, **changes: Any) -> None:
        wanted = replace(self._wanted, **changes)
        if wanted != self._wanted:
            self._wanted = wanted
            self.is_computing = True
            self.bridge.request(wanted)
        self._refresh()

    def _refresh(self) -> None:
        self.sections.draw(self.settings.background, self.picks.editor.picks)
        self.cursor_text.setText(f"Cursor: {self.scene.read_out(self.place)}")
        self.caption.setText(self._caption())
        problems = list(self.session.doubts)
        if self._problem is not None:
            problems.append(self._problem)
        elif self.sections.problem is not None:
            problems.append(Message("no traces: {reason}", reason=self.sections.problem))
        self.problem.setText("\n".join(shown(one) for one in problems))
        self.problem.setVisible(bool(problems))
        notes = [*self.session.notes, *self.picks.notes]
        if self.image is not None:
            notes = [*(one for one in self.image.notes if one not in notes), *notes]
        self.notes.setPlainText("\n\n".join(map(shown, notes)))
        self._tabs.setTabText(self._tabs.indexOf(self.notes), f"Notes ({len(notes)})")

    def _caption(self) -> str:
        caption = "no image yet" if self.image is None else f"Image: {self.image.caption}"
        if self.is_computing:
            caption += f" · computing for permittivity {self.settings.permittivity:.3g} ..."
        return caption

    def _go_to(self, name: str) -> None:
        places: List[Any] = [*self.picks.editor.picks]
        places += [] if self.image is None else self.image.candidates.candidates
        for one in places:
            if one.id == name:
                self.move_to(Place(one.x_m, one.y_m, one.depth_m))

    def _ask_in_dialog(self, question: str) -> bool:
        answer = QMessageBox.question(self, self.windowTitle(), question)
        return bool(answer == QMessageBox.StandardButton.Yes)

    def _connect(self) -> None:
        self.sections.placed.connect(self.move_to)
        settings = self.settings
        settings.permittivity_changed.connect(lambda value: self._request(permittivity=value))
        settings.background_changed.connect(lambda value: self._request(background=value))
        settings.display_changed.connect(self._refresh)
        for tab in (self.candidates, self.picks):
            tab.table.chosen.connect(self._go_to)
        self.picks.pick_wanted.connect(self.pick)
        self.picks.changed.connect(lambda: self.sections.draw_marks(self.picks.editor.picks))

    def _add_keys(self) -> None:
        """Let keys work; a text that is being edited takes them first."""
        settings, picks = self.settings, self.picks
        menu = self.menuBar().addMenu("Keys")
        # A held key must not pick, undo or switch again and again.
        for text, keys, repeats, act in (
            ("Cursor to smaller x", ["Left"], True, lambda: self.nudge(columns=-1)),
            ("Cursor to larger x", ["Right"], True, lambda: self.nudge(columns=1)),
            ("Cursor to larger y", ["Up"], True, lambda: self.nudge(rows=1)),
            ("Cursor to smaller y", ["Down"], True, lambda: self.nudge(rows=-1)),
            ("Cursor and slice upwards", ["PgUp"], True, lambda: self.nudge(layers=-1)),
            ("Cursor and slice downwards", ["PgDown"], True, lambda: self.nudge(layers=1)),
            ("Larger permittivity", ["+", "="], True, lambda: settings.step_permittivity(1)),
            ("Smaller permittivity", ["-"], True, lambda: settings.step_permittivity(-1)),
            ("Pick the place of the cursor", ["P"], False, self.pick),
            ("Undo the last change of the picks", ["Ctrl+Z"], False, picks.undo),
            ("Delete the selected pick", ["Del"], False, picks.delete_selected),
            ("Next polarization", ["R"], False, lambda: settings.next("polarization")),
            ("Section along the other axis", ["L"], False, lambda: settings.next("section")),
            ("Background on or off", ["B"], False, settings.switch_background),
        ):
            action = QAction(text, menu)
            action.setShortcuts([QKeySequence(one) for one in keys])
            action.setAutoRepeat(repeats)
            action.triggered.connect(lambda _checked, act=act: act())
            menu.addAction(action)

    def _lay_out(self) -> None:
        views, sections = QGridLayout(), self.sections
        columns = [(sections.b_scan, sections.section)]
        if len(self.session.axes) > 1:
            # Below a single line there is one section, which is the whole image.
            columns.append((sections.slice, sections.maximum))
        for column, pair in enumerate(columns):
            views.setColumnStretch(column, 1)
            for row, view in enumerate(pair):
                views.setRowStretch(row, 1)
                # All get the same space, whatever they would like.
                view.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
                views.addWidget(view, row, column)
        self._tabs = tabs = QTabWidget()
        tabs.addTab(self.picks, "Picks")
        tabs.addTab(self.candidates, "Candidates")
        tabs.addTab(self.notes, "Notes")
        # On a low screen the settings scroll, so that the pictures are seen whole.
        side, below = QScrollArea(), _column(self.settings, sections.scale_view, tabs)
        side.setWidget(below)
        side.setWidgetResizable(True)
        side.setFrameShape(QFrame.Shape.NoFrame)
        side.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        bar_px = side.verticalScrollBar().sizeHint().width()
        side.setMinimumWidth(below.minimumSizeHint().width() + bar_px)
        side.setMaximumWidth(SIDE_PX)
        middle = QHBoxLayout()
        middle.addLayout(views, 3)
        middle.addWidget(side, 2)
        pictures = QWidget()
        pictures.setLayout(middle)
        central = _column(self.banner, self.caption, self.problem, pictures, self.cursor_text)
        self.setCentralWidget(central)
        self.resize(*SIZE_PX)


def _column(*widgets: QWidget) -> QWidget:
    column = QWidget()
    layout = QVBoxLayout(column)
    layout.setContentsMargins(4, 4, 4, 4)
    for widget in widgets:
        # The tabs, and the pictures, take the space that is left.
        layout.addWidget(widget, int(isinstance(widget, QTabWidget) or type(widget) is QWidget))
    return column


def show(session: ViewSession, picks: Path, author: str, name: str) -> None:
    """Show the window; return when it was closed.

    Raises:
        PicksFileError: The stored picks are damaged or of another survey.
        KeyboardInterrupt: It was ended with Ctrl-C.
    """
    file = PicksFile(picks, SurveyIdentity.of(session.survey))
    application = QApplication.instance() or QApplication(sys.argv[:1])
    pyqtgraph.setConfigOptions(antialias=True)
    window = MainWindow(session, PicksTab(file, author, lambda: iso_text(time_of_day_us())), name)
    interrupted = []

    def interrupt(*_: object) -> None:
        interrupted.append(True)
        application.quit()

    former = {one: signal.signal(one, interrupt) for one in (signal.SIGINT, signal.SIGTERM)}
    ticks = QTimer()
    ticks.timeout.connect(lambda: None)
    ticks.start(SIGNALS_PERIOD_MS)
    try:
        window.show()
        application.exec_()
    finally:
        window.bridge.close()
        # Ctrl-C leaves it open.
        window.hide()
        sip.delete(window)
        for number, handler in former.items():
            signal.signal(number, handler)
    if interrupted:
        raise KeyboardInterrupt
