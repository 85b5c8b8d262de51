"""The three buttons that move a robot."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QPushButton, QWidget


class CommandBar(QWidget):
    """START, STOP and RESUME."""

    start_pressed = pyqtSignal()
    stop_pressed = pyqtSignal()
    resume_pressed = pyqtSignal()

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self.start = self._button("start", self.tr("START"))
        self.stop = self._button("stop", self.tr("STOP"))
        self.resume = self._button("resume", self.tr("RESUME"))
        self.start.clicked.connect(self.start_pressed)
        self.stop.clicked.connect(self.stop_pressed)
        self.resume.clicked.connect(self.resume_pressed)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(12)
        layout.addWidget(self.start, 1)
        layout.addWidget(self.stop, 2)
        layout.addWidget(self.resume, 1)
        self.enable(start=False, stop=False, resume=False)

    def enable(self, start: bool, stop: bool, resume: bool) -> None:
        """Say which buttons can be pressed."""
        self.start.setEnabled(start)
        self.stop.setEnabled(stop)
        self.resume.setEnabled(resume)

    @staticmethod
    def _button(name: str, text: str) -> QPushButton:
        button = QPushButton(text)
        button.setObjectName(name)
        return button
