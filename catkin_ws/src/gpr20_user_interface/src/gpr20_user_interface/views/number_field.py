"""A field with a number, and arrows that change it."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QHBoxLayout, QLineEdit, QPushButton, QSizePolicy, QWidget

from gpr20_user_interface.views.style import TOUCH_PX, set_wrong

# More characters than any parameter needs.
MAX_LENGTH = 40
REPEAT_DELAY_MS = 400
REPEAT_MS = 120


class TouchEdit(QLineEdit):
    """A line that tells when it is tapped; a keyboard can write in it as usual."""

    tapped = pyqtSignal()

    def __init__(self, name: str, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setMaxLength(MAX_LENGTH)
        self.setMinimumWidth(TOUCH_PX)
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
        set_wrong(self, bool(problem))
        self.setToolTip(problem)


class NumberField(QWidget):
    """An edit between two arrows."""

    # Carries +1 or -1.
    stepped = pyqtSignal(int)

    def __init__(self, name: str, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
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
