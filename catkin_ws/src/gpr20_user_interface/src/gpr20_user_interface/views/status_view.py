"""The STATUS tab: state, progress, positions and health."""

from __future__ import annotations

import math
from typing import Dict, Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QProgressBar,
    QVBoxLayout,
    QWidget,
)

from gpr20_user_interface.mid.displays import remaining
from gpr20_user_interface.mid.events import ControlState, Position, Progress
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.health_panel import HealthPanel
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text

UNKNOWN = "—"
# The progress bar counts in thousandths.
FULL = 1000
HEIGHT_COLUMN = 4


class TouchText(QPlainTextEdit):
    """A text of any length that reports a touch."""

    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setReadOnly(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        # A finger scrolls and touches; it selects nothing.
        self.setTextInteractionFlags(Qt.TextInteractionFlag.NoTextInteraction)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the text."""
        super().mouseReleaseEvent(event)
        if self.viewport().rect().contains(event.pos()):
            self.touched.emit()


class MessagePanel(TranslatedWidget):
    """A title for the state and the message below it, however long."""

    # Carries the ControlState whose message was touched.
    touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._shown: Optional[ControlState] = None
        self._title = QLabel(UNKNOWN)
        self._title.setObjectName("title")
        self.text = TouchText()
        self.text.setObjectName("status_message")
        self.text.touched.connect(self._on_touched)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self._title)
        layout.addWidget(self.text)

    @property
    def title(self) -> str:
        """The title that is shown."""
        return self._title.text()

    @property
    def message(self) -> str:
        """The message that is shown."""
        return self.text.toPlainText()

    def show_state(self, state: Optional[ControlState]) -> None:
        """Show the last status; None: there was none yet."""
        # Written only when it changes, so that a reader does not lose the place.
        if state != self._shown:
            self._shown = state
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        message = "" if self._shown is None else shown_text(self._shown.message)
        if message != self.text.toPlainText():
            self.text.setPlainText(message)
        title = None if self._shown is None else self._shown.title
        self._title.setText(UNKNOWN if title is None else shown_text(title))

    def _on_touched(self) -> None:
        if self._shown is not None:
            self.touched.emit(self._shown)


class ProgressPanel(TranslatedWidget):
    """A bar with the percentage; below it traces and remaining time."""

    def __init__(self) -> None:
        super().__init__()
        self._progress: Optional[Progress] = None
        self._bar = QProgressBar()
        self._bar.setRange(0, FULL)
        self._text = QLabel()
        self._remaining = QLabel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        for widget in (self._bar, self._text, self._remaining):
            layout.addWidget(widget)
        self.show_progress(None)

    @property
    def thousandths(self) -> int:
        """The position of the bar."""
        return self._bar.value()

    @property
    def texts(self) -> str:
        """The two lines below the bar."""
        return f"{self._text.text()}\n{self._remaining.text()}"

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.show_progress(self._progress)

    def show_progress(self, progress: Optional[Progress]) -> None:
        """Show the progress; None shows that there is none."""
        self._progress = progress
        if progress is None or progress.total_points == 0:
            self._bar.setValue(0)
            self._bar.setFormat(self.tr("no survey"))
            self._text.clear()
            self._remaining.clear()
            return
        # Rounded down: only a complete survey is shown as 100 %.
        self._bar.setValue(math.floor(progress.completion_percent * FULL / 100.0))
        percent = math.floor(progress.completion_percent * 10.0) / 10.0
        self._bar.setFormat(f"{percent:.1f} %")
        self._text.setText(
            self.tr("{visited} of {total} traces, {remaining} to go").format(
                visited=progress.visited_points,
                total=progress.total_points,
                remaining=progress.total_points - progress.visited_points,
            )
        )
        self._remaining.setText(shown_text(remaining(progress)))


class PositionPanel(TranslatedWidget):
    """X, Y and Z, now and as the target, and the height over the ground."""

    def __init__(self) -> None:
        super().__init__()
        self._cells: Dict[Tuple[str, int], QLabel] = {}
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        self._titles = [self._label("") for _ in range(HEIGHT_COLUMN)]
        for column, label in enumerate(self._titles, 1):
            label.setObjectName("quiet")
            grid.addWidget(label, 0, column)
        self._rows = [QLabel(), QLabel()]
        for row, (name, columns) in enumerate((("current", HEIGHT_COLUMN), ("target", 3)), 1):
            grid.addWidget(self._rows[row - 1], row, 0)
            for column in range(1, columns + 1):
                self._cells[name, column] = self._label(UNKNOWN)
                self._cells[name, column].setObjectName("figure")
                grid.addWidget(self._cells[name, column], row, column)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        titles = (self.tr("X mm"), self.tr("Y mm"), self.tr("Z °"), self.tr("Height m"))
        for label, title in zip(self._titles, titles):
            label.setText(title)
        for label, title in zip(self._rows, (self.tr("Now"), self.tr("Target"))):
            label.setText(title)

    def cell(self, row: str, column: int) -> str:
        """Return the text of a cell: row "current" or "target", column from 1."""
        return self._cells[row, column].text()

    def refresh(self, snapshot: Snapshot) -> None:
        """Show position, target and height, as far as they are known now."""
        self._show("current", snapshot.current)
        self._show("target", snapshot.target)
        height_m = snapshot.height_m
        self._cells["current", HEIGHT_COLUMN].setText(
            UNKNOWN if height_m is None else f"{height_m:.3f}"
        )

    def _show(self, row: str, position: Optional[Position]) -> None:
        for column, name in enumerate(("x_mm", "y_mm", "z_deg"), 1):
            text = UNKNOWN if position is None else f"{getattr(position, name):.2f}"
            self._cells[row, column].setText(text)

    @staticmethod
    def _label(text: str) -> QLabel:
        label = QLabel(text)
        flags = Qt.Alignment() | Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        label.setAlignment(flags)
        return label


class StatusView(QWidget):
    """State, progress and positions on the left, health on the right."""

    def __init__(self) -> None:
        super().__init__()
        self.message = MessagePanel()
        self.progress = ProgressPanel()
        self.positions = PositionPanel()
        self.health = HealthPanel()
        left = QVBoxLayout()
        left.addWidget(self.message, 1)
        left.addWidget(self.progress)
        left.addWidget(self.positions)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 6)
        layout.setSpacing(12)
        layout.addLayout(left, 1)
        layout.addWidget(self.health, 1)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self.message.show_state(snapshot.state)
        self.progress.show_progress(snapshot.progress)
        self.positions.refresh(snapshot)
        self.health.show_health(snapshot.health)
