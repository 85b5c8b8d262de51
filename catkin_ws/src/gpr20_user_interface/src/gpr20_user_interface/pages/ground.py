"""GROUND: follows the survey that is shown, and passes the operator's wishes on."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, Optional, Tuple

import numpy as np
from PyQt5.QtCore import QObject, QSize, pyqtSignal
from PyQt5.QtGui import QPixmap
from PyQt5.QtWidgets import QLabel, QPushButton, QSizePolicy, QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.grid import SurveyGrid, plan_finer
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.sources import Axis, Layer
from gpr20_operator.ground.texts import STATE_NAMES, place_text
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.palette import TILES, pattern_colours
from gpr20_operator.plan.fields import Keys
from gpr20_operator.plan.texts import remove_marker_question
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.notices import Refused
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.annotation import check_text
from gpr20_survey.plan.markers import MAX_TEXT_CHARACTERS, TEXT, Marker
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground_view import GroundView
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.plot import image_of
from gpr20_user_interface.widgets.widgets import Overlay, Page, column, new_button, offer, row, say

SWATCH_PX = 24
NAMES = {
    Layer.COVERAGE: Message("Coverage"),
    Layer.ECHOES: Message("Echoes"),
    Layer.FOCUSED: Message("Focused\nimage"),
    Layer.HIDING: Message("Hiding\nplaces"),
}


class LayersSheet(Overlay):
    """Keys that are labelled with what is shown now; the first row chooses the layer."""

    changed = pyqtSignal()

    def __init__(self, window: QWidget, model: GroundModel) -> None:
        super().__init__(window)
        self._model = model
        self.layers = {one: self._key(partial(model.change, layer=one)) for one in Layer}
        self.legend: Dict[StopState, Tuple[QLabel, QLabel]] = {
            one: (QLabel(), QLabel()) for one in STATE_NAMES
        }
        self.next_problem = self._key(model.choose_next_problem)
        self.along = self._key(model.turn)
        self.polarization = self._key(model.next_polarization)
        self.follow = self._key(lambda: model.follow(not model.follows))
        self.done = self._key(self.hide)
        say(self.done, Message("CLOSE"))
        self.next_problem.clicked.connect(self.hide)
        for layer, key in self.layers.items():
            key.setCheckable(True)
            say(key, NAMES[layer])
        self._lay_out()
        self._show()

    def open(self) -> None:
        """Show what is chosen now, over the page."""
        self._show()
        super().open()

    def show_again(self) -> None:
        """Paint the swatches in the colours of the look."""
        look = look_of(self)
        size = look.px(SWATCH_PX)
        for state, (swatch, _count) in self.legend.items():
            image = image_of(np.tile(TILES[state], (2, 2)), pattern_colours(look.theme))
            swatch.setPixmap(QPixmap.fromImage(image.copy(0, 0, size, size)))
            swatch.setFixedSize(QSize(size, size))

    def _show(self) -> None:
        model, settings, grid = self._model, self._model.settings, self._model.survey.radar.grid
        for layer, key in self.layers.items():
            key.setChecked(layer is settings.layer)
        # Nobody asked yet where a mine could hide: that takes minutes.
        asked = None if model.additions.hiding is not None else Message("Hiding: ask\nin Result")
        offer(self.layers[Layer.HIDING], NAMES[Layer.HIDING], asked)
        counts = model.survey.map.counts()
        for state, (_swatch, label) in self.legend.items():
            number = "—" if counts is None else str(counts[state])
            say(label, Message("{name}: {number}", name=STATE_NAMES[state], number=number))
        gap = model.survey.map.next_problem(None) is not None
        offer(self.next_problem, Message("Next\ngap"), None if gap else Message("No gap\nis left"))
        rotation_deg = 0.0 if grid is None else grid.rotations_deg[settings.polarization]
        say(self.polarization, Message("Antenna\n{rotation:g}°", rotation=rotation_deg))
        along_x, along_y = Message("Section\nalong X"), Message("Section\nalong Y")
        say(self.along, along_x if settings.along is Axis.X_MM else along_y)
        follows, stays = Message("Crosshair\nlast trace"), Message("Crosshair\nstays")
        say(self.follow, follows if model.follows else stays)

    def _key(self, act: Callable[[], None]) -> QPushButton:
        key = new_button(lambda: self._do(act))
        key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        key.setObjectName("ground_choice")
        return key

    def _do(self, act: Callable[[], None]) -> None:
        act()
        self._show()
        self.changed.emit()

    def _lay_out(self) -> None:
        swatches = (part for one, name in self.legend.values() for part in (one, (name, 1)))
        keys = self.along, self.polarization, self.follow, self.done
        # CLOSE ends below the middle, where other sheets have what is held.
        rows = (
            (row(*((one, 1) for one in self.layers.values())), 3),
            (row((row(*swatches), 4), (self.next_problem, 1)), 3),
            (row(*((one, 1) for one in keys)), 2),
        )
        self.setLayout(column(*rows, margin=GAP_PX))


class GroundPage(QObject, Page):
    """Shows the running survey, or a past one that was opened, with what belongs to it.

    Args:
        window: The window that the sheets cover.
        survey: The survey that runs.
        traces: Which survey is shown.
        additions: What belongs to that survey.
        imaging: Asks for focused images while the page is seen.
        show_refusal: Shows why something did not succeed.
    """

    # A FinerPlan that is to be measured now.
    finer_chosen = pyqtSignal(object)
    # A past survey was opened: the page should be seen.
    wanted = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        traces: TracePresenter,
        additions: AdditionsPresenter,
        imaging: Imaging,
        show_refusal: Callable[[Refused, Message], None],
    ) -> None:
        super().__init__(window)
        self._survey, self._traces, self._additions = survey, traces, additions
        self._imaging, self._show_refusal = imaging, show_refusal
        # A survey, and its place (X, Y, depth) that is shown as soon as the survey is here.
        self._awaited: Tuple[str, Tuple[float, float, float]] = "", (0.0, 0.0, 0.0)
        self.model = GroundModel(traces.shown, additions)
        self.view = GroundView(self.model)
        self.layers = LayersSheet(window, self.model)
        self.note_pad, self.confirm = Pad(window), HoldSheet(window)
        view = self.view
        view.set_marker.clicked.connect(lambda: self._on_marker())
        view.finer.clicked.connect(lambda: self._on_finer())
        view.layers.clicked.connect(lambda: self.layers.open())
        view.back.clicked.connect(lambda: self._show_live())
        view.opened.connect(additions.read_again)
        additions.marking_failed = partial(show_refusal, Refused.MARKER)
        self.layers.changed.connect(view.refresh)

    def show_place(self, x_mm: float, y_mm: float, depth_mm: Optional[float] = None) -> None:
        """Bring crosshair, picture and depth to a place of the survey that is shown."""
        self.model.choose_place(x_mm, y_mm, depth_mm)
        self.view.show_place(x_mm, y_mm)

    def show_place_of(
        self, survey_id: str, folder: str, x_mm: float, y_mm: float, depth_mm: float
    ) -> None:
        """Show a place of a survey, which is read first if another one is shown."""
        self._awaited = survey_id, (x_mm, y_mm, depth_mm)
        if self._traces.running.survey_id == survey_id:
            self._traces.show_live()
        elif self._traces.shown.survey_id != survey_id:
            self._traces.open_survey(folder)
        self._follow()

    def measure_finer(self, grid: SurveyGrid, x_mm: float, y_mm: float) -> None:
        """Plan a small survey around a place of another one; nothing moves by it."""
        try:
            self._survey.finer = plan_finer(grid, x_mm, y_mm)
        except InvalidValueError as error:
            self._show_refusal(Refused.FINER, error.message)
        else:
            self.finer_chosen.emit(self._survey.finer)

    def on_event(self, event: object) -> None:
        """Take what belongs to a survey."""
        self._traces.on_event(event)
        self._follow()
        if isinstance(event, Answer) and event.request is Request.START and event.success:
            self._survey.finer = None

    def show_state(self, snapshot: Snapshot) -> None:
        """Follow the survey that is shown; request the missing traces and draw what is new."""
        self._traces.note_state(snapshot)
        self._follow()
        self._additions.follow(self._traces.shown.map.grid)
        self._additions.refresh()
        self._traces.refresh()
        view, imaging = self.view, self._imaging
        if view.isVisible():
            self.model.keep_image(imaging)
        view.is_running, view.is_replay = snapshot.running, bool(snapshot.replay)
        view.problem = imaging.problem
        view.carriage_mm = self._traces.carriage_mm
        view.refresh()

    def show_again(self) -> None:
        """Show the same in another language, theme or size."""
        self.view.show_again()
        self.layers.show_again()

    def _show_live(self) -> None:
        self._traces.show_live()
        self._follow()

    def _on_marker(self) -> None:
        """Remove the marker that was touched, after a hold, or set one at the crosshair."""
        mark, additions, point = self.model.mark, self._additions, self.model.point
        if isinstance(mark, Marker):
            place, marker_id = place_text(mark.x_mm, mark.y_mm, mark.depth_mm), mark.marker_id
            question = remove_marker_question(place, mark.text)
            self.confirm.ask(question, lambda: additions.remove_marker(marker_id))
        elif point is not None and additions.survey_id:
            # Another survey may begin while the text is written.
            self._ask_text(additions.survey_id, *point)

    def _ask_text(self, survey: str, x_mm: float, y_mm: float, depth_mm: Optional[float]) -> None:
        """Ask for the text of a marker, and store it."""

        def add(text: str) -> None:
            try:
                self._additions.add_marker(survey, x_mm, y_mm, depth_mm, text)
            except InvalidValueError as error:
                self._show_refusal(Refused.MARKER, error.message)

        self.note_pad.ask(
            add,
            shown_text(Message("Text of the marker")),
            shown_text(Message("at most {count} characters", count=MAX_TEXT_CHARACTERS)),
            "",
            _problem_of_text,
            Keys.LETTERS,
        )

    def _on_finer(self) -> None:
        grid, point = self._traces.shown.map.grid, self.model.point
        if grid is not None and point is not None:
            self.measure_finer(grid, *point[:2])

    def _follow(self) -> None:
        """Show another survey if another one was opened, or the running one again."""
        self.view.show_band(self._traces.band)
        shown, (awaited, place) = self._traces.shown, self._awaited
        if shown is not self.model.survey:
            self.model.show_survey(shown)
            self.view.refresh()
            if self._traces.opened_folder:
                self.wanted.emit()
        if awaited and awaited == shown.survey_id:
            self._awaited = "", place
            self.show_place(*place)
            self.wanted.emit()


def _problem_of_text(text: str) -> str:
    try:
        check_text(TEXT, text, MAX_TEXT_CHARACTERS)
    except InvalidValueError as error:
        return shown_text(error.message)
    return ""
