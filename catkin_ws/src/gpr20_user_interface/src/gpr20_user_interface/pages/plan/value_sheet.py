"""The sheet of a tile: its fields, what a touch fills in, and keys for all of them."""

from __future__ import annotations

from typing import List

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gpr20_operator.plan.fields import SPECS, TILE_FIELDS, VALUE_TILES, FieldSpec, Tile
from gpr20_operator.plan.form import PlanForm, quarter_wavelength_mm
from gpr20_operator.plan.presets import Preset
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.keys import CLEAR, ERASE, KeyBlock
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.tile import TileButton
from gpr20_user_interface.widgets.widgets import fill, in_two_lines, new_button, set_look, space

FIELDS_PX, PRESETS_PX, KEYS_PX, BUTTON_PX, FIELD_PX = 252, 232, 284, 134, 84
MOST_FIELDS = max(len(TILE_FIELDS[tile]) for tile in VALUE_TILES)
PRESET_COLUMNS, PRESET_ROWS = 2, 4
PRESET_FRAME_PX = 10
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
        self.title, self.hint = QLabel(), QLabel()
        self.title.setObjectName("title")
        self.hint.setWordWrap(True)
        self.undo, self.done = new_button(self._on_undo), new_button(self.finish)
        self.done.setObjectName("primary")
        self.fields = [self._field(number) for number in range(MOST_FIELDS)]
        self.presets = [self._preset(number) for number in range(PRESET_COLUMNS * PRESET_ROWS)]
        self.keys = KeyBlock()
        self.keys.written.connect(self.write)
        self.keys.commanded.connect(self._on_command)
        self._lay_out()
        self.retranslate()

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
        """Close; what was understood is what is shown from now on."""
        self._form.normalize()
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

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(shown_text(self._tile.value))
        self.undo.setText(self.tr("UNDO"))
        self.done.setText(self.tr("DONE"))
        self._show()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        space(self, self._rows, self._top, self._body, self._left, self._grid)
        self._fields.setFixedWidth(look.px(FIELDS_PX))
        self._presets.setFixedWidth(look.px(PRESETS_PX))
        for field in self.fields:
            field.setMaximumHeight(look.px(FIELD_PX))
        for button in (self.undo, self.done):
            button.setFixedSize(look.px(BUTTON_PX), look.px(TOUCH_PX))

    @property
    def _name(self) -> str:
        return self._specs[self._active].name

    def _choose(self, number: int) -> None:
        self._active, self._fresh, self._touched = number, True, False
        self.retranslate()

    def _show(self) -> None:
        """Show texts, keys, presets, and what is wrong or allowed."""
        if not self._specs:
            return
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
        room_px = look_of(self).px((PRESETS_PX - GAP_PX) / PRESET_COLUMNS - PRESET_FRAME_PX)
        for number, button in enumerate(self.presets):
            button.setVisible(number < len(self._offered))
            if number < len(self._offered):
                preset = self._offered[number]
                button.setText(in_two_lines(shown_text(preset.title), button, room_px))
                fits = (self._form.texts[name] == text for name, text in preset.texts.items())
                button.setChecked(all(fits))

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

    def _preset(self, number: int) -> QPushButton:
        button = new_button(lambda: self._on_preset(number))
        button.setObjectName("preset")
        button.setCheckable(True)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        button.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        return button

    def _lay_out(self) -> None:
        self._top, self._body, self._rows = QHBoxLayout(), QHBoxLayout(), QVBoxLayout(self)
        fill(self._top, self.title, (self.hint, 1), self.undo, self.done)
        self._fields, self._presets = QWidget(), QWidget()
        self._left = QVBoxLayout(self._fields)
        fill(self._left, *((field, 10) for field in self.fields))
        self._left.addStretch(1)
        self._grid = QGridLayout(self._presets)
        for number, button in enumerate(self.presets):
            row, column = divmod(number, PRESET_COLUMNS)
            self._grid.addWidget(button, row, column)
            self._grid.setRowStretch(row, 1)
            self._grid.setColumnStretch(column, 1)
        for layout in (self._left, self._grid):
            layout.setContentsMargins(0, 0, 0, 0)
        fill(self._body, self._fields, self._presets, (self.keys, 1))
        fill(self._rows, self._top, (self._body, 1))
