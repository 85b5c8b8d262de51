"""The sheet of a tile: its fields, what a touch fills in, and keys for all of them."""

from __future__ import annotations

from typing import Dict, List, Mapping, Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gpr20_operator.plan.fields import SPECS, TILE_FIELDS, VALUE_TILES
from gpr20_operator.plan.form import PlanCheck, PlanForm
from gpr20_operator.plan.memory import ARROW_STEPS
from gpr20_operator.plan.presets import Preset, PresetContext
from gpr20_operator.plan.preview import quarter_wavelength_mm
from gpr20_operator.plan.spec import TILE_TITLES, FieldSpec, Tile
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.edits import FieldBox, TouchEdit
from gpr20_user_interface.widgets.keys import CLEAR, DOWN, STEP, UP, KeyBlock
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import in_two_lines, new_button, set_look

FIELDS_PX, PRESETS_PX, KEYS_PX = 252, 232, 284
MOST_FIELDS = max(len(TILE_FIELDS[tile]) for tile in VALUE_TILES)
PRESET_COLUMNS, PRESET_ROWS = 2, 4
BUTTON_PX = 134
PRESET_FRAME_PX = 10
BOX_PX = 84


class ValueSheet(Overlay):
    """Writes in the plan at once; UNDO brings back what there was when it was opened.

    Args:
        window: What it covers.
        form: The plan.
    """

    # The plan, or the step of the arrows, has changed.
    changed = pyqtSignal()

    def __init__(self, window: QWidget, form: PlanForm) -> None:
        super().__init__(window)
        self._form = form
        self._tile, self._active, self._touched = Tile.AREA, 0, False
        self._specs: List[FieldSpec] = [SPECS[name] for name in TILE_FIELDS[self._tile]]
        self._before: Mapping[str, str] = {}
        self._following = form.following
        self.last_area: Mapping[str, str] = {}
        self.arrow_step = ARROW_STEPS[0]
        self.title = QLabel()
        self.title.setObjectName("title")
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        self.undo = new_button(self._on_undo)
        self.done = new_button(self.finish)
        self.boxes: List[FieldBox] = [self._box(number) for number in range(MOST_FIELDS)]
        self.presets: List[QPushButton] = [self._preset() for _ in range(8)]
        self._offered: List[Preset] = []
        self.keys = KeyBlock()
        self.keys.written.connect(self._on_written)
        self.keys.commanded.connect(self._on_command)
        self._lay_out()
        self.retranslate()

    @property
    def fields(self) -> Dict[str, TouchEdit]:
        """The edits that are shown, by the name of their field."""
        return {spec.name: box.edit for spec, box in zip(self._specs, self.boxes)}

    def show_tile(self, tile: Tile) -> None:
        """Open with the fields of a tile; the first key replaces the first value."""
        # The tile before may have had more fields.
        self._tile, self._active, self._touched = tile, 0, False
        self._specs = [SPECS[name] for name in TILE_FIELDS[tile]]
        self._before, self._following = dict(self._form.texts), self._form.following
        for number, box in enumerate(self.boxes):
            box.setVisible(number < len(self._specs))
        self.retranslate()
        self._show_texts()
        self.open()
        self._choose(0)

    def finish(self) -> None:
        """Close; what was understood is what is shown from now on."""
        self._form.normalize()
        self.hide()
        self.changed.emit()

    def choose(self, name: str) -> None:
        """Let the keys write in a field of the tile."""
        self._choose(TILE_FIELDS[self._tile].index(name))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(shown_text(TILE_TITLES[self._tile]))
        self.undo.setText(self.tr("UNDO"))
        self.done.setText(self.tr("DONE"))
        for spec, box in zip(self._specs, self.boxes):
            box.title.setText(shown_text(spec.title))
            box.edit.setPlaceholderText("" if spec.empty is None else shown_text(spec.empty))
        self._show_state()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px = look.px(GAP_PX)
        for layout in (self._rows, self._top, self._body, self._left, self._grid):
            layout.setSpacing(gap_px)
        self._rows.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
        self._fields.setFixedWidth(look.px(FIELDS_PX))
        self._presets.setFixedWidth(look.px(PRESETS_PX))
        for box in self.boxes:
            box.setMaximumHeight(look.px(BOX_PX))
        for button in (self.undo, self.done):
            button.setFixedSize(look.px(BUTTON_PX), look.px(TOUCH_PX))

    def _choose(self, number: int) -> None:
        self._active, self._touched = number, False
        for other, box in enumerate(self.boxes):
            box.set_chosen(other == number)
        edit = self.boxes[number].edit
        edit.setFocus()
        edit.select_all()
        self._show_state()

    def _show_state(self) -> None:
        """Show keys, presets, and what is wrong or allowed."""
        spec, check = self._specs[self._active], self._form.check()
        for number, (one, box) in enumerate(zip(self._specs, self.boxes)):
            # Nothing is wrong before something was written.
            judged = number != self._active or self._touched
            problem = check.problems.get(one.name) if judged else None
            box.show_problem("" if problem is None else shown_text(problem))
        problem = check.problems.get(spec.name) if self._touched else None
        self.hint.setText(shown_text(problem or spec.hint(self._form.travel)))
        set_look(self.hint, "level", "wrong" if problem else "")
        self.keys.use(spec.kind.keys, self.arrow_step)
        context = PresetContext(
            self._form.travel, self.last_area, self._form.proposed_address, _quarter_mm(check)
        )
        self._offered = spec.presets(context)
        for number, button in enumerate(self.presets):
            offered = number < len(self._offered)
            button.setVisible(offered)
            if offered:
                self._show_preset(button, self._offered[number])

    def _show_preset(self, button: QPushButton, preset: Preset) -> None:
        room_px = look_of(self).px((PRESETS_PX - GAP_PX) / PRESET_COLUMNS - PRESET_FRAME_PX)
        button.setText(in_two_lines(shown_text(preset.title), button, room_px))
        texts = self._form.texts
        button.setChecked(all(texts[name] == text for name, text in preset.texts.items()))

    def _show_texts(self) -> None:
        """Show the texts of the plan; the field that is being written is left alone."""
        for name, edit in self.fields.items():
            if edit.text() != self._form.texts[name]:
                edit.setText(self._form.texts[name])

    def _on_written(self, text: str) -> None:
        self.boxes[self._active].edit.insert(text)
        self._on_edited(self._active)

    def _on_command(self, command: str) -> None:
        edit = self.boxes[self._active].edit
        if command in (UP, DOWN):
            name = self._specs[self._active].name
            self._form.arrow(name, self.arrow_step if command == UP else -self.arrow_step)
            self._after_fill()
        elif command == STEP:
            place = ARROW_STEPS.index(self.arrow_step) + 1
            self.arrow_step = ARROW_STEPS[place % len(ARROW_STEPS)]
            self._show_state()
            self.changed.emit()
        else:
            edit.clear() if command == CLEAR else edit.backspace()
            self._on_edited(self._active)

    def _on_edited(self, number: int) -> None:
        self._touched = True
        self._form.set_text(self._specs[number].name, self.boxes[number].edit.text())
        self._show_texts()
        self._show_state()
        self.changed.emit()

    def _on_preset(self, number: int) -> None:
        self._form.set_texts(self._offered[number].texts)
        self._after_fill()

    def _on_undo(self) -> None:
        self._form.restore(self._before, self._following)
        self._after_fill()

    def _after_fill(self) -> None:
        self._show_texts()
        self._choose(self._active)
        self.changed.emit()

    def _box(self, number: int) -> FieldBox:
        edit = TouchEdit(f"value_{number}")
        edit.textEdited.connect(lambda _text: self._on_edited(number))
        edit.returnPressed.connect(self.finish)
        box = FieldBox(edit)
        box.tapped.connect(lambda: self._choose(number))
        return box

    def _preset(self) -> QPushButton:
        button = new_button(lambda: self._on_preset(self.presets.index(button)))
        button.setObjectName("preset")
        button.setCheckable(True)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        button.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        return button

    def _lay_out(self) -> None:
        self._top = QHBoxLayout()
        self._top.addWidget(self.title)
        self._top.addWidget(self.hint, 1)
        self._top.addWidget(self.undo)
        self._top.addWidget(self.done)
        self._fields = QWidget()
        self._left = QVBoxLayout(self._fields)
        self._left.setContentsMargins(0, 0, 0, 0)
        for box in self.boxes:
            self._left.addWidget(box, 10)
        self._left.addStretch(1)
        self._presets = QWidget()
        self._grid = QGridLayout(self._presets)
        self._grid.setContentsMargins(0, 0, 0, 0)
        for number, button in enumerate(self.presets):
            self._grid.addWidget(button, number // PRESET_COLUMNS, number % PRESET_COLUMNS)
        for row in range(PRESET_ROWS):
            self._grid.setRowStretch(row, 1)
        for column in range(PRESET_COLUMNS):
            self._grid.setColumnStretch(column, 1)
        self._body = QHBoxLayout()
        self._body.addWidget(self._fields)
        self._body.addWidget(self._presets)
        self._body.addWidget(self.keys, 1)
        self._rows = QVBoxLayout(self)
        self._rows.addLayout(self._top)
        self._rows.addLayout(self._body, 1)


def _quarter_mm(check: PlanCheck) -> Optional[float]:
    if check.parameters is None or check.permittivity is None:
        return None
    return quarter_wavelength_mm(check.parameters, check.permittivity)
