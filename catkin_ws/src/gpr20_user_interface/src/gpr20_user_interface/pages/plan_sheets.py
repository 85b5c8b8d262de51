"""The sheets of the plan: its fields, and name, operator, site, position and notes of a survey."""

from __future__ import annotations

from typing import Dict, List

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_operator.plan.fields import (
    PEOPLE,
    SPECS,
    TILE_FIELDS,
    FieldSpec,
    Preset,
    Tile,
)
from gpr20_operator.plan.form import (
    PlanForm,
    annotation_from,
    annotation_texts,
    quarter_wavelength_mm,
)
from gpr20_operator.plan.texts import change_records_question
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.annotation import EMPTY, Annotation, annotation_of
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.keys import CLEAR, ERASE, KeyBlock, Pad
from gpr20_user_interface.widgets.tile import ElidedLabel, TileButton
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    column,
    grid,
    holding,
    new_button,
    new_label,
    offer,
    row,
    set_look,
    tiled,
)

# Those whose sheet has keys for all fields at once.
VALUE_TILES = tuple(tile for tile in Tile if tile is not Tile.NAME)
MOST_FIELDS = max(len(TILE_FIELDS[tile]) for tile in VALUE_TILES)
PRESET_COLUMNS, PRESET_ROWS = 2, 4
# More characters than any parameter needs, an address of any form included.
MAX_LENGTH = 80


class ValueSheet(Overlay):
    """Writes in the plan at once; UNDO brings back what there was when it was opened."""

    # The plan has changed.
    changed = pyqtSignal()

    def __init__(self, window: QWidget, form: PlanForm) -> None:
        super().__init__(window)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._form = form
        self._tile, self._active = Tile.AREA, 0
        self._specs: List[FieldSpec] = []
        # Whether the next key replaces the text, and whether something was written.
        self._fresh, self._touched = True, False
        self._before = dict(form.texts)
        self._offered: List[Preset] = []
        self.title, self.hint = new_label("title"), new_label(wraps=True)
        self.undo = new_button(self._on_undo, Message("UNDO"))
        self.done = new_button(self.finish, Message("DONE"))
        self.done.setObjectName("primary")
        for button in (self.undo, self.done):
            set_look(button, "corner", True)
        self.fields = [self._field(number) for number in range(MOST_FIELDS)]
        self.presets = [self._preset(number) for number in range(PRESET_COLUMNS * PRESET_ROWS)]
        self.keys = KeyBlock()
        self.keys.written.connect(self.write)
        self.keys.commanded.connect(self._on_command)
        self._lay_out()

    def show_tile(self, tile: Tile) -> None:
        """Open with the fields of a tile; the first key replaces the first value."""
        self._tile, self._specs = tile, [SPECS[name] for name in TILE_FIELDS[tile]]
        self._before = dict(self._form.texts)
        for number, field in enumerate(self.fields):
            field.setVisible(number < len(self._specs))
        self._choose(0)
        self.open()
        self.setFocus()

    def finish(self) -> None:
        """Close."""
        self.hide()
        self.changed.emit()

    def choose(self, name: str) -> None:
        """Let the keys write in a field of the tile."""
        self._choose(TILE_FIELDS[self._tile].index(name))

    def write(self, text: str) -> None:
        """Write in the chosen field; the first text replaces what is there."""
        former = "" if self._fresh else self._form.texts[self._name]
        self._set_text((former + text)[:MAX_LENGTH])

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Qt: a key of a real keyboard."""
        commands = {Qt.Key.Key_Backspace: ERASE, Qt.Key.Key_Delete: CLEAR}
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.finish()
        elif event.key() in commands:
            self._on_command(commands[Qt.Key(event.key())])
        elif event.text().isprintable() and event.text():
            self.write(event.text())
        else:
            super().keyPressEvent(event)

    @property
    def _name(self) -> str:
        return self._specs[self._active].name

    def _choose(self, number: int) -> None:
        self._active, self._fresh, self._touched = number, True, False
        self._show()

    def _show(self) -> None:
        """Show texts, keys, presets, and what is wrong or allowed."""
        self.title.setText(shown_text(self._tile.value))
        chosen, check = self._specs[self._active], self._form.check()
        for spec, field in zip(self._specs, self.fields):
            text, active = self._form.texts[spec.name], spec is chosen
            # Nothing is wrong before something was written.
            wrong = spec.name in check.problems and (self._touched or not active)
            empty = "" if spec.empty is None else shown_text(spec.empty)
            shown = f"{text}|" if active and not self._fresh else text or empty
            level = "wrong" if wrong else "chosen" if active else ""
            field.show_texts(shown_text(spec.title), shown, level=level)
        problem = check.problems.get(chosen.name) if self._touched else None
        self.hint.setText(shown_text(problem or chosen.hint(self._form.travel)))
        set_look(self.hint, "level", "wrong" if problem else "")
        self.keys.use(chosen.kind.keys)
        quarter_mm = None
        if check.parameters is not None and check.permittivity is not None:
            quarter_mm = quarter_wavelength_mm(check.parameters, check.permittivity)
        self._offered = chosen.presets(self._form.travel, quarter_mm)
        for number, button in enumerate(self.presets):
            button.setVisible(number < len(self._offered))
            if number < len(self._offered):
                preset = self._offered[number]
                fits = all(self._form.texts[name] == text for name, text in preset.texts.items())
                level = "chosen" if fits else ""
                button.show_texts("", sentence=shown_text(preset.title), level=level)

    def _set_text(self, text: str) -> None:
        self._fresh, self._touched = False, True
        self._form.set_text(self._name, text)
        self._show()
        self.changed.emit()

    def _on_command(self, command: str) -> None:
        erased = "" if self._fresh or command == CLEAR else self._form.texts[self._name][:-1]
        self._set_text(erased)

    def _on_preset(self, number: int) -> None:
        self._form.set_texts(self._offered[number].texts)
        self._after_fill()

    def _on_undo(self) -> None:
        self._form.restore(self._before)
        self._after_fill()

    def _after_fill(self) -> None:
        self._choose(self._active)
        self.changed.emit()

    def _field(self, number: int) -> TileButton:
        field = TileButton(lines=1)
        field.title.setObjectName("field_title")
        field.lines[0].setObjectName("figure")
        field.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        field.clicked.connect(lambda: self._choose(number))
        return field

    def _preset(self, number: int) -> TileButton:
        button = TileButton(lines=0)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        button.clicked.connect(lambda: self._on_preset(number))
        return button

    def _lay_out(self) -> None:
        fields = column(*((field, 10) for field in self.fields))
        fields.addStretch(1)
        presets = holding(tiled(self.presets, PRESET_COLUMNS), "value_presets")
        body = row(holding(fields, "value_fields"), presets, (self.keys, 1))
        top = row(self.title, (self.hint, 1), self.undo, self.done)
        self.setLayout(column(top, (body, 1), margin=GAP_PX))


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
        self.save = new_button(self._on_save)
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
        self.title.setText(survey if self.survey else self.tr("Next survey"))
        for name, tile in self.tiles.items():
            empty = SPECS[name].empty if not self.survey else None
            shown = self.texts[name] or ("" if empty is None else shown_text(empty))
            tile.show_texts(shown_text(SPECS[name].title), sentence=shown or "—")
        changed = self.texts != annotation_texts(self._before)
        offer(self.save, Message("SAVE"), None if changed else Message("NOTHING\nNEW"))

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
