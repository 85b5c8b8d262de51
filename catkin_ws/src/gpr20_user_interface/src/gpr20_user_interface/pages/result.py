"""The result of a survey: one image, at most five ranked places, and what can be done next.

It searches by itself when a survey has ended and the page is seen.
"""

from __future__ import annotations

from typing import Callable, Dict, List

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QProgressBar, QStackedWidget, QWidget

from gpr20_common.message import Message, in_a_row, verbatim
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.ground.sources import FocusedSource
from gpr20_operator.ground.texts import GroundMark
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.result import CANCELLED, PLACES_SHOWN, SURVEY_RUNS, SurveyResult
from gpr20_operator.plan.texts import resumable, resume_lines
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import NO_CLEARANCE, Candidate, Flag
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import Languages, shown_text
from gpr20_user_interface.pages.result_entries import PlaceSheet, SoilSheet
from gpr20_user_interface.pages.result_sheets import (
    DoubtsSheet,
    HidingSheet,
    StickSheet,
    with_remedy,
)
from gpr20_user_interface.widgets.ground_picture import GroundPicture
from gpr20_user_interface.widgets.tile import SurveyBand, TileButton
from gpr20_user_interface.widgets.widgets import (
    EmptyState,
    Page,
    column,
    holding,
    new_button,
    new_label,
    row,
    say,
    set_look,
    tiled,
)

SURE, WEAKER = Message("sure echo"), Message("weaker echo")
# What a person does about what makes a place to check doubtful.
FIRST_STEPS: Dict[Flag, Message] = {
    Flag.ONE_POLARIZATION: Message("measure finer"),
    Flag.EDGE: Message("measure beyond"),
    Flag.SURFACE_RESIDUE: Message("see the surface"),
    Flag.BRIGHTEST: Message("only the brightest"),
}


class ResultPage(QWidget, Page):
    """Shows the result of the survey that has ended, or of a stored one that was opened.

    Args:
        window: The window that its sheets cover.
        result: The result.
        past: The stored surveys.
        languages: Languages of the window.
        operator: Returns who operates the robot now.
    """

    # Id and folder of a survey; X, Y and depth of a place in mm.
    show_wanted = pyqtSignal(str, str, float, float, float)
    # A SurveyGrid, X and Y in mm.
    finer_wanted = pyqtSignal(object, float, float)
    # The operator plans the next survey, or resumes the one in a folder.
    plan_wanted = pyqtSignal()
    resume_wanted = pyqtSignal(str)

    def __init__(
        self,
        window: QWidget,
        result: SurveyResult,
        past: PastSurveys,
        languages: Languages,
        operator: Callable[[], str],
    ) -> None:
        super().__init__()
        self.result, self._past = result, past
        # Folder of the survey that is shown, if it can be resumed.
        self._offered = ""
        self.place_sheet = PlaceSheet(window, result, operator)
        self.soil_sheet = SoilSheet(window, result)
        self.hiding_sheet = HidingSheet(window, result)
        self.stick_sheet = StickSheet(window, result, lambda: languages.language.value)
        self.doubts_sheet = DoubtsSheet(window, result)
        self.sheets = (
            *(self.place_sheet, self.soil_sheet, self.hiding_sheet),
            *(self.stick_sheet, self.doubts_sheet),
        )
        self.place_sheet.finer_wanted.connect(self._on_finer)
        self.place_sheet.show_wanted.connect(self._on_show)
        self._drawn: object = None
        self._drawn_image: object = None
        self.title = new_label("first_title", wraps=True)
        self.no_clearance = new_label("small_alarm", wraps=True, text=NO_CLEARANCE)
        self.nothing = new_label("first_title", wraps=True, text=texts.NOT_SAFE)
        self.band = SurveyBand()
        self.doubts = new_button(self.doubts_sheet.open_now)
        self.doubts.setObjectName("doubts")
        self.resume = new_button(lambda: self.resume_wanted.emit(self._offered))
        self.resume.setObjectName("primary")
        self.picture = GroundPicture(beside=True)
        self.picture.mark_touched.connect(self.place_sheet.ask)
        self.rows: List[TileButton] = [self._row(number) for number in range(PLACES_SHOWN)]
        self.card = EmptyState()
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)  # it is not known how long it takes
        self.stick = new_button(self.stick_sheet.ask, Message("Report\nto stick"))
        self.stick.setObjectName("primary")
        hiding = Message("Where could\na mine hide?")
        self.hiding = new_button(self.hiding_sheet.open_now, hiding)
        self.soil = new_button(self.soil_sheet.ask)
        self.more = new_button(self._on_more)
        self.plan = new_button(self.plan_wanted.emit, Message("Plan the\nnext survey"))
        self.keys = (self.stick, self.hiding, self.soil, self.plan)
        self._lay_out()
        self._show()

    def show_state(self, snapshot: Snapshot) -> None:
        """Search while the page is seen; during a survey only what is known is shown."""
        self.result.note_running(snapshot.running)
        self.result.latest_id = "" if snapshot.state is None else snapshot.state.survey_id
        if snapshot.running:
            for sheet in (*self.sheets, self.place_sheet.pad, self.soil_sheet.pad):
                sheet.hide()
        if self.isVisible():
            self.result.keep()
            # Whether one is plugged in is seen before the report is asked for.
            self.result.export.look_for_sticks()
        offered = resumable(self._past, snapshot)
        is_here = offered is not None and self.result.survey in (offered.survey_id, offered.folder)
        if offered is not None:
            self._offered, stored = offered.folder, resume_lines(self._past, offered)[1]
            self.resume.setText(f"{self.tr('RESUME')}: {shown_text(stored)}")
        self.resume.setVisible(is_here)
        self.show_now()

    def end(self) -> None:
        """End what is awaited."""
        self.result.end()
        self.result.export.job.end()

    def show_now(self) -> None:
        """Show what has changed, of the page and of the sheets."""
        revision = self.result.revision
        if self.isVisible() and revision != self._drawn:
            self._drawn = revision
            self._show()
        for sheet in self.sheets:
            sheet.refresh()

    def show_again(self) -> None:
        """Show the same in another language, theme or size."""
        self._drawn_image = self._drawn = None
        self._show()

    def _show(self) -> None:
        result, record, image = self.result, self.result.record, self.result.image
        self.band.show_band(texts.band(result))
        doubts = len(texts.doubts(result))
        self.doubts.setVisible(doubts > 0)
        say(self.doubts, Message("Doubts: {count}", count=doubts))
        can_ask = record is not None and not result.survey_runs
        self.stick.setEnabled(can_ask)
        plugged = any(one.writable for one in result.export.sticks.volumes)
        say(
            self.stick,
            Message("Report\nto stick") if plugged else Message("Report: plug\na stick in"),
        )
        self.hiding.setEnabled(image is not None and can_ask)
        self.soil.setEnabled(can_ask)
        self.soil.setText("\n".join(shown_text(one) for one in texts.soil_lines(result)))
        more = len(result.places) - len(result.shown)
        self.more.setVisible(more > 0)
        say(self.more, Message("{count}\nmore", count=more))
        # Nothing of another survey, nor of the search before.
        for tile, place in zip(self.rows, (*result.shown, *[None] * PLACES_SHOWN)):
            tile.setVisible(place is not None)
            tile.setEnabled(not result.survey_runs)
            if place is not None:
                self._show_row(tile, place)
        self._stack.setCurrentIndex(int(image is not None))
        self._right.setCurrentIndex(int(image is not None and not result.places))
        if image is None:
            self._show_state()
        else:
            self._show_image(image)

    def _show_row(self, tile: TileButton, place: Candidate) -> None:
        found = self.result.find_at(place)
        where = f"{place.number}: {shown_text(texts.place_line(place))}"
        line = _line(place) if found is None else texts.found_line(found)
        level = "locked" if place.is_doubtful else "" if place.flags else "sure"
        tile.show_texts(where, shown_text(line), level=level)

    def _show_state(self) -> None:
        result, record = self.result, self.result.record
        reading, search = result.reading, result.search
        running = reading.running or search.running
        failed = search.problem or (reading.problem if record is None else None)
        part = texts.measured(result)
        named = "" if record is None else record.name
        self.title.setText(named if part is None else shown_text(part))
        self.progress.setVisible(running)
        if result.waits:
            self.card.explain("pause", shown_text(SURVEY_RUNS))
        elif running:
            text = shown_text(texts.SEARCHING if search.running else texts.READING)
            self.card.explain("search", text, self.tr("CANCEL"), result.cancel)
        elif failed is not None:
            again = self.tr("SEARCH") if failed == CANCELLED else self.tr("TRY AGAIN")
            self.card.explain("warning", with_remedy(failed), again, result.try_again)
        else:
            self.card.explain("search", shown_text(texts.READING))

    def _show_image(self, image: FocusedImage) -> None:
        result = self.result
        self.title.setText(shown_text(texts.headline(image.found)))
        if image is not self._drawn_image:
            self._drawn_image = image
            self.picture.show_picture(FocusedSource(image).from_above())
        self.picture.set_hiding(result.hiding.result)
        self.picture.set_marks(
            [
                GroundMark(
                    *(one.x_mm, one.y_mm, str(one.number)),
                    doubtful=one.is_doubtful,
                    chosen=one == result.chosen,
                    about=one,
                )
                for one in reversed(result.shown)
            ]
        )
        self.picture.set_notice("\n".join(shown_text(one) for one in texts.notices(result)))
        above, hidden = texts.FROM_MARK, result.hiding.result
        if hidden is not None:
            named = {one.value.name: text for one, text in texts.TARGETS.items()}
            name = named.get(hidden.target.name, verbatim(hidden.target.name))
            above = Message("Hatched: {target} could hide", target=name)
        self.picture.labels = "X", shown_text(above)

    def _row(self, number: int) -> TileButton:
        tile = TileButton(lines=1)
        tile.title.setObjectName("first_title")
        tile.lines[0].setObjectName("small")
        tile.clicked.connect(lambda: self.place_sheet.ask(self.result.shown[number]))
        return tile

    def _on_more(self) -> None:
        self.result.turn_page()
        self.show_now()

    def _lay_out(self) -> None:
        gap = GAP_PX // 2
        places = column(*((one, 1) for one in self.rows), gap=1)
        places.addStretch()
        self._right, self._stack = QStackedWidget(), QStackedWidget()
        self._right.addWidget(holding(places, "places"))
        self._right.addWidget(self.nothing)
        self._stack.addWidget(holding(column((self.card, 1), self.progress, margin=gap)))
        self._stack.addWidget(self.picture)
        for key in (*self.keys, self.more, self.doubts, self.resume):
            set_look(key, "compact", True)
        above = self.band, self.doubts, self.resume
        left = column(*above, (self._stack, 1), self.no_clearance, gap=gap)
        top = row((self.title, 1), self.more)
        beside = column(top, (self._right, 1), tiled(self.keys, 2), gap=gap)
        self.setLayout(row((left, 1), holding(beside, "result_panel"), margin=gap // 2, gap=gap))

    def _on_finer(self, place: Candidate) -> None:
        if self.result.record is not None:
            self.finer_wanted.emit(self.result.record.grid, place.x_mm, place.y_mm)

    def _on_show(self, place: Candidate) -> None:
        if self.result.record is not None:
            survey = self.result.record.survey_id, self.result.survey
            self.show_wanted.emit(*survey, place.x_mm, place.y_mm, place.depth_mm)


def _line(place: Candidate) -> Message:
    """Return how deep a place is, and whether it is sure; else what to do first."""
    word = WEAKER if place.is_doubtful else SURE
    first = next((FIRST_STEPS[flag] for flag in place.flags if flag in FIRST_STEPS), None)
    if first is not None and not place.is_doubtful:
        word = first
    return in_a_row([Message("{deep} mm deep", deep=place.place_texts[2]), word])
