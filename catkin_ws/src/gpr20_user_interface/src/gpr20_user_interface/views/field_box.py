"""A field with its title inside: all of it takes the touch."""

from __future__ import annotations

from typing import Union

from PyQt5.QtCore import QEvent, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QFrame, QLabel, QPlainTextEdit, QVBoxLayout

from gpr20_user_interface.views.look import TOUCH_PX, look_of
from gpr20_user_interface.views.touch_edit import TouchEdit
from gpr20_user_interface.views.widgets import set_look


class TouchText(QPlainTextEdit):
    """Lines of text that report a tap; a keyboard can write in them as usual."""

    tapped = pyqtSignal()

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setTabChangesFocus(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the field."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()

    def text(self) -> str:
        """Return the text."""
        return self.toPlainText()

    def setText(self, text: str) -> None:  # noqa: N802 (as in QLineEdit)
        """Replace the text."""
        self.setPlainText(text)

    def show_problem(self, problem: str) -> None:
        """Say what is wrong; an empty problem: nothing is."""
        self.setToolTip(problem)


Field = Union[TouchEdit, TouchText]


class FieldBox(QFrame):
    """A title above an edit, in one frame."""

    tapped = pyqtSignal()

    def __init__(self, edit: Field) -> None:
        super().__init__()
        self.setObjectName("box")
        self.edit = edit
        self.title = QLabel()
        self.title.setObjectName("quiet")
        if isinstance(edit, TouchEdit):
            edit.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignLeft)
        edit.tapped.connect(self.tapped)
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        self._layout.addWidget(self.title)
        self._layout.addWidget(edit, 1)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        self.setMinimumHeight(look.px(TOUCH_PX))
        self._layout.setContentsMargins(look.px(8), look.px(4), look.px(8), look.px(4))

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            self.restyle()

    def set_chosen(self, chosen: bool) -> None:
        """Show whether the keys write in this field."""
        set_look(self, "chosen", chosen)

    def show_problem(self, problem: str) -> None:
        """Mark the field as wrong; an empty problem as right."""
        if self.property("wrong") is not bool(problem):
            set_look(self, "wrong", bool(problem))
            # The rules for what is inside ask for the frame.
            for child in (self.title, self.edit):
                self.style().unpolish(child)
                self.style().polish(child)
        self.edit.show_problem(problem)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the frame around the edit."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()
