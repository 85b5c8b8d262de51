"""The fields of the parameters."""

from __future__ import annotations

from typing import Dict, List, Mapping, Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QWidget,
)

from gpr20_user_interface.mid.parameter_form import (
    ADDRESS,
    ANALYZER_FIELDS,
    FIELDS,
    ROTATIONS,
)
from gpr20_user_interface.views.translation import TranslatedWidget
from gpr20_user_interface.views.widgets import set_look

# More characters than any parameter needs.
MAX_LENGTH = 40
REPEAT_DELAY_MS = 400
REPEAT_MS = 120
OCTETS = 4
VISA_SEPARATOR = "::"
ROWS = (
    ("start_frequency_hz", "stop_frequency_hz", "frequency_points"),
    ("x_start_mm", "x_stop_mm", "x_points"),
    ("y_start_mm", "y_stop_mm", "y_points"),
)


class TouchEdit(QLineEdit):
    """A line that reports a tap; a keyboard can write in it as usual."""

    tapped = pyqtSignal()

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setMaxLength(MAX_LENGTH)
        self.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the field."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()

    def show_problem(self, problem: str) -> None:
        """Mark the field as wrong; an empty problem as right."""
        set_look(self, "wrong", bool(problem))
        self.setToolTip(problem)


class NumberField(QWidget):
    """An edit between two arrows."""

    # Carries +1 or -1.
    stepped = pyqtSignal(int)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.edit = TouchEdit(name)
        self.down = self._arrow("▼", -1)
        self.up = self._arrow("▲", +1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.down)
        layout.addWidget(self.edit, 1)
        layout.addWidget(self.up)

    def _arrow(self, text: str, direction: int) -> QPushButton:
        button = QPushButton(text)
        button.setObjectName("arrow")
        button.setAutoRepeat(True)
        button.setAutoRepeatDelay(REPEAT_DELAY_MS)
        button.setAutoRepeatInterval(REPEAT_MS)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        button.clicked.connect(lambda: self.stepped.emit(direction))
        return button


class ParameterFormView(TranslatedWidget):
    """Shows the parameters as texts and reports changes."""

    changed = pyqtSignal()
    # Carries the parameter's name and +1 or -1.
    stepped = pyqtSignal(str, int)
    # Carries the edit.
    tapped = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._octets: List[TouchEdit] = []
        self._dots: List[QLabel] = []
        # The name of a VISA resource: it cannot be entered here and comes from the configuration.
        self._resource = QLabel()
        self._edits: Dict[str, TouchEdit] = {}
        self._fields: Dict[str, NumberField] = {}
        self._row_titles = [QLabel() for _ in range(1 + len(ROWS))]
        self._column_titles = [QLabel() for _ in ROWS[0]]
        self._rotation_title = QLabel()
        self._analyzer_titles = [QLabel() for _ in ANALYZER_FIELDS]
        self._lay_out()
        for field in FIELDS:
            self.show_text(field.name, field.default)
        for edit in self.edits():
            edit.textChanged.connect(self.changed)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        titles = (self.tr("VNA"), self.tr("MHz"), self.tr("X mm"), self.tr("Y mm"))
        for label, title in zip(self._row_titles, titles):
            label.setText(title)
        columns = (self.tr("Start"), self.tr("Stop"), self.tr("Points"))
        for label, title in zip(self._column_titles, columns):
            label.setText(title)
        self._rotation_title.setText(self.tr("Antennas °"))
        settings = (self.tr("IF bandwidth Hz"), self.tr("Averages"), self.tr("Output power"))
        for label, name, title in zip(self._analyzer_titles, ANALYZER_FIELDS, settings):
            label.setText(title)
            self._edits[name].setPlaceholderText(self.tr("as set"))

    def texts(self) -> Dict[str, str]:
        """Return the text of every field by the name of its parameter."""
        found = {name: edit.text() for name, edit in self._edits.items()}
        octets = [octet.text() for octet in self._octets]
        found[ADDRESS] = self._resource.text() or _address(octets)
        return found

    def texts_with(self, edit: TouchEdit, text: str) -> Dict[str, str]:
        """Return what the texts would be with another one in one of the edits."""
        found = self.texts()
        if edit in self._octets:
            octets = [text if one is edit else one.text() for one in self._octets]
            found[ADDRESS] = _address(octets)
        else:
            found[edit.objectName()] = text
        return found

    def show_text(self, name: str, text: str) -> None:
        """Put a text into the field of a parameter."""
        if name != ADDRESS:
            self._edits[name].setText(text)
            return
        is_resource = VISA_SEPARATOR in text
        self._resource.setText(text if is_resource else "")
        self._resource.setToolTip(self._resource.text())
        self._resource.setVisible(is_resource)
        for widget in (*self._octets, *self._dots):
            widget.setVisible(not is_resource)
        parts = [] if is_resource else text.split(".", OCTETS - 1)
        for octet, part in zip(self._octets, parts + [""] * OCTETS):
            octet.setText(part)

    def edit(self, name: str) -> QLineEdit:
        """Return the field of a parameter; of the address its first."""
        return self._octets[0] if name == ADDRESS else self._edits[name]

    def octet(self, number: int) -> QLineEdit:
        """Return a field of the address, from 0."""
        return self._octets[number]

    def field(self, name: str) -> NumberField:
        """Return the field of a parameter with its arrows."""
        return self._fields[name]

    def edits(self) -> List[TouchEdit]:
        """Return every field that can be tapped."""
        return [*self._octets, *self._edits.values()]

    def name_of(self, edit: TouchEdit) -> str:
        """Return the parameter to which an edit belongs."""
        return ADDRESS if edit in self._octets else edit.objectName()

    def show_problems(self, problems: Mapping[str, str]) -> None:
        """Mark the fields that are wrong, by the name of their parameter."""
        for edit in self.edits():
            edit.show_problem(problems.get(self.name_of(edit), ""))

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(4)
        # Two rows of titles and five of fields, with the figures below, in 480 pixels.
        grid.setVerticalSpacing(2)
        grid.addWidget(self._row_titles[0], 0, 0)
        grid.addLayout(self._address_and_rotations(), 0, 1, 1, len(ROWS[0]))
        self._add_row(grid, 1, self._analyzer_titles, ANALYZER_FIELDS)
        self._add_row(grid, 3, self._column_titles, ROWS[0])
        for row, names in enumerate(ROWS[1:], 5):
            self._add_row(grid, row, (), names)
        for row, title in enumerate(self._row_titles[1:], 4):
            grid.addWidget(title, row, 0)

    def _add_row(
        self, grid: QGridLayout, row: int, titles: Sequence[QLabel], names: Sequence[str]
    ) -> None:
        """Add fields, below a row of titles if there are any."""
        for column, label in enumerate(titles, 1):
            label.setObjectName("quiet")
            grid.addWidget(label, row, column)
            grid.setColumnStretch(column, 1)
        for column, name in enumerate(names, 1):
            grid.addWidget(self._number_field(name), row + bool(titles), column)

    def _address_and_rotations(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(2)
        for number in range(OCTETS):
            if number:
                self._dots.append(QLabel("."))
                row.addWidget(self._dots[-1])
            octet = self._touch_edit(f"octet{number}")
            self._octets.append(octet)
            row.addWidget(octet, 2)
        self._resource.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        row.addWidget(self._resource, OCTETS * 2)
        row.addSpacing(12)
        row.addWidget(self._rotation_title)
        self._edits[ROTATIONS] = self._touch_edit(ROTATIONS)
        row.addWidget(self._edits[ROTATIONS], 4)
        return row

    def _number_field(self, name: str) -> NumberField:
        field = NumberField(name)
        field.stepped.connect(lambda direction: self.stepped.emit(name, direction))
        field.edit.tapped.connect(lambda: self.tapped.emit(field.edit))
        self._fields[name] = field
        self._edits[name] = field.edit
        return field

    def _touch_edit(self, name: str) -> TouchEdit:
        edit = TouchEdit(name)
        edit.tapped.connect(lambda: self.tapped.emit(edit))
        return edit


def _address(octets: Sequence[str]) -> str:
    # Without any digit it is that of the robot's configuration.
    return ".".join(octets) if any(octets) else ""
