"""A number with a button on either side, for fingers in gloves."""

from __future__ import annotations

from typing import Optional, Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from gpr20_user_interface.views.style import TOUCH_PX


class Stepper(QWidget):
    """Chooses one of a few numbers."""

    changed = pyqtSignal(float)

    def __init__(
        self, values: Sequence[float], start: float, parent: Optional[QWidget] = None
    ) -> None:
        super().__init__(parent)
        self._values = list(values)
        self._place = self._values.index(start)
        self._title, self._pattern = "", "{value:g}"
        self.less = self._button("\N{MINUS SIGN}")
        self.more = self._button("+")
        self._label = QLabel()
        self._label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.less)
        layout.addWidget(self._label, 1)
        layout.addWidget(self.more)
        self.less.clicked.connect(lambda: self._step(-1))
        self.more.clicked.connect(lambda: self._step(+1))
        self._show()

    @property
    def value(self) -> float:
        """The number that is chosen."""
        return self._values[self._place]

    @property
    def text(self) -> str:
        """What is written between the buttons."""
        return self._label.text()

    def set_texts(self, title: str, pattern: str) -> None:
        """Say what the number is; the pattern holds {value}."""
        self._title, self._pattern = title, pattern
        self._show()

    def _step(self, direction: int) -> None:
        place = min(max(self._place + direction, 0), len(self._values) - 1)
        if place != self._place:
            self._place = place
            self._show()
            self.changed.emit(self.value)

    def _show(self) -> None:
        self._label.setText(f"{self._title}\n{self._pattern.format(value=self.value)}")
        self.less.setEnabled(self._place > 0)
        self.more.setEnabled(self._place < len(self._values) - 1)

    @staticmethod
    def _button(text: str) -> QPushButton:
        button = QPushButton(text)
        button.setObjectName("small")
        button.setFixedWidth(TOUCH_PX)
        return button
