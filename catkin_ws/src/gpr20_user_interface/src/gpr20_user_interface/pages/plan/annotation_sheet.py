"""Name, operator, site, position and notes of the next survey, or of one that exists."""

from __future__ import annotations

from typing import Dict

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_operator.plan.annotation import annotation_from, annotation_texts
from gpr20_operator.plan.fields import PEOPLE, SPECS
from gpr20_operator.plan.hold_question import change_records_question
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.annotation import EMPTY, Annotation, annotation_of
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.labels import ElidedLabel
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.tile import TileButton
from gpr20_user_interface.widgets.widgets import column, grid, new_button, row, set_look

# Row, column, and how many columns.
PLACES = {
    "name": (0, 0, 1),
    "operator": (0, 1, 1),
    "site": (1, 0, 1),
    "position": (1, 1, 1),
    "notes": (2, 0, 2),
}


class AnnotationSheet(Overlay):
    """A tile for each text, which opens keys on the screen when it is touched.

    The records of a survey that exists are changed only by a hold.

    Attributes:
        survey: The survey of the records, an id or the name of its folder; empty: the next one.
    """

    # Carries the Annotation of the next survey.
    saved = pyqtSignal(object)
    # Carries the reason, a Message, why records could not be read or changed.
    failed = pyqtSignal(object)

    def __init__(self, window: QWidget, storage: Imaging) -> None:
        super().__init__(window)
        failed = self.failed.emit
        self._reading: Job[StoredSurvey] = storage.job(Service.READ, self._take, failed)
        self._storing: Job[Message] = storage.job(Service.FACT, self._on_stored, failed)
        # The survey that is read, and the one whose records are stored.
        self._wanted = self._stored = ""
        self.confirm = HoldSheet(window)
        self.survey = ""
        self._before = EMPTY
        self.texts: Dict[str, str] = annotation_texts(EMPTY)
        self.title = ElidedLabel()
        self.title.setObjectName("title")
        self.pad = Pad(window)
        self.tiles: Dict[str, TileButton] = {one.name: TileButton(lines=0) for one in PEOPLE}
        for name, tile in self.tiles.items():
            tile.clicked.connect(lambda _checked, name=name: self._ask(name))
        self.save = new_button(self._on_save, Message("SAVE"))
        self.close_button = new_button(self.hide, Message("CLOSE"))
        for button in (self.save, self.close_button):
            set_look(button, "corner", True)
        self._lay_out()
        self.show_now()

    def read(self, survey: str) -> None:
        """Open with what the storage has of a survey, by its id or the name of its folder."""
        self._wanted = survey
        self._reading.ask(survey=survey)

    def show_annotation(self, survey: str, annotation: Annotation) -> None:
        """Open with the annotation of a survey, by id or folder; empty: of the next one."""
        self.survey, self._before = survey, annotation
        self.texts = annotation_texts(annotation)
        self.show_now()
        self.open()

    def show_now(self) -> None:
        """Write what is entered."""
        survey = self.tr("Survey {survey}").format(survey=self.survey)
        self.title.show_text(survey if self.survey else self.tr("Next survey"))
        for name, tile in self.tiles.items():
            empty = SPECS[name].empty if not self.survey else None
            shown = self.texts[name] or ("" if empty is None else shown_text(empty))
            tile.show_texts(shown_text(SPECS[name].title), sentence=shown or "—")
        self.save.setEnabled(self.texts != annotation_texts(self._before))

    def _take(self, stored: StoredSurvey) -> None:
        try:
            description = parse_object(stored.text, "metadata_json", MAX_FILE_BYTES)
            self.show_annotation(self._wanted, annotation_of(description))
        except (SurveyRefusedError, InvalidValueError) as error:
            self.failed.emit(error.message)

    def _on_stored(self, _said: Message) -> None:
        if self._stored == self.survey:
            self.hide()

    def _on_save(self) -> None:
        before, survey = self._before, self.survey
        after = annotation_from(self.texts)
        if not survey:
            self.hide()
            self.saved.emit(after)
            return

        def store() -> None:
            # The sheet stays open until the storage has it.
            self._stored = survey
            values = {**after.values(), "notes_before": before.notes}
            self._storing.ask(survey=survey, kind=Kind.ANNOTATION, values=values)

        question = change_records_question(before.name or survey, before, after)
        self.confirm.ask(question, store)

    def _ask(self, name: str) -> None:
        spec = SPECS[name]

        def judge(text: str) -> str:
            try:
                spec.kind.read(text)
            except InvalidValueError as error:
                return shown_text(error.message)
            return ""

        def deliver(text: str) -> None:
            self.texts[name] = text
            self.show_now()

        hint = shown_text(spec.allowed(DOCUMENTED_TRAVEL))
        self.pad.ask(deliver, shown_text(spec.title), hint, self.texts[name], judge, spec.kind.keys)

    def _lay_out(self) -> None:
        tiles = grid()
        for name, (line, place, columns) in PLACES.items():
            tiles.addWidget(self.tiles[name], line, place, 1, columns)
            tiles.setColumnStretch(place, 1)
        tiles.setRowStretch(2, 1)
        top = row((self.title, 1), self.close_button, self.save)
        self.setLayout(column(top, (tiles, 1), margin=GAP_PX))
