"""What must not be overlooked, at the top of the window."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QVBoxLayout, QWidget


class Banners(QWidget):
    """Says that the robot is simulated, and that main_control is not there."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._simulated = self._label("banner")
        self._simulated.setText(self.tr("SIMULATED robot: these data show no real ground"))
        self._absent = self._label("alarm")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self._simulated)
        layout.addWidget(self._absent)

    @property
    def texts(self) -> str:
        """What is shown now."""
        labels = (self._simulated, self._absent)
        return "\n".join(label.text() for label in labels if not label.isHidden())

    def show_simulated(self, simulated: bool) -> None:
        """Say whether the robot is simulated."""
        self._simulated.setVisible(simulated)

    def show_control(self, alive: bool, silent_s: Optional[float]) -> None:
        """Say whether main_control is there, and for how long [s] it has been silent."""
        self._absent.setVisible(not alive)
        if alive:
            return
        if silent_s is None:
            text = self.tr(
                "main_control is not heard; it starts with: roslaunch gpr20 survey.launch"
            )
        else:
            text = self.tr(
                "main_control not heard for {seconds} s: the robot may still move; waiting for it"
            ).format(seconds=int(silent_s))
        self._absent.setText(text)

    @staticmethod
    def _label(name: str) -> QLabel:
        label = QLabel()
        label.setObjectName(name)
        label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        label.setWordWrap(True)
        label.hide()
        return label
