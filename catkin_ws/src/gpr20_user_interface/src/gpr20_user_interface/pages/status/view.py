"""The STATUS tab: state, progress, positions and health."""

from __future__ import annotations

import math
from typing import Dict, Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QProgressBar,
    QScrollArea,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from gpr20_operator.robot.events import ControlState, Position, Progress
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.job import remaining, time_passes
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.pages.status.health_panel import HealthPanel
from gpr20_user_interface.widgets.labels import ElidedLabel
from gpr20_user_interface.widgets.widgets import new_button

UNKNOWN = "—"
# The progress bar counts in thousandths.
FULL = 1000
HEIGHT_COLUMN = 4
MEGABYTES_PER_GIGABYTE = 1000.0


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
    """A bar with the percentage; below it the traces and the time that is left."""

    def __init__(self) -> None:
        super().__init__()
        self._progress: Optional[Progress] = None
        self._running = False
        self._bar = QProgressBar()
        self._bar.setRange(0, FULL)
        self._text = ElidedLabel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self._bar)
        layout.addWidget(self._text)
        self.show_progress(None, False)

    @property
    def thousandths(self) -> int:
        """The position of the bar."""
        return self._bar.value()

    @property
    def text(self) -> str:
        """The line below the bar."""
        return self._text.whole

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.show_progress(self._progress, self._running)

    def show_progress(self, progress: Optional[Progress], running: bool) -> None:
        """Show the progress.

        Args:
            progress: How far the survey is; None shows that there is none.
            running: Whether time passes that is left.
        """
        self._progress, self._running = progress, running
        if progress is None or progress.total_points == 0:
            self._bar.setValue(0)
            self._bar.setFormat(self.tr("no survey"))
            self._text.show_text("")
            return
        # Rounded down: only a complete survey is shown as 100 %.
        self._bar.setValue(math.floor(progress.completion_percent * FULL / 100.0))
        percent = math.floor(progress.completion_percent * 10.0) / 10.0
        self._bar.setFormat(f"{percent:.1f} %")
        text = self.tr("{visited} of {total} traces").format(
            visited=progress.visited_points, total=progress.total_points
        )
        if running and not progress.is_complete:
            text = f"{text}, {shown_text(remaining(progress))}"
        self._text.show_text(text)


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


class FactsPanel(TranslatedWidget):
    """Free space on the disk, and the calibration of the VNA."""

    def __init__(self) -> None:
        super().__init__()
        self._report = HealthReport()
        self._disk_title, self._disk = QLabel(), QLabel()
        self._calibration_title, self._calibration = QLabel(), ElidedLabel()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(2)
        for row, (title, figure) in enumerate(
            ((self._disk_title, self._disk), (self._calibration_title, self._calibration))
        ):
            title.setObjectName("quiet")
            grid.addWidget(title, row, 0)
            grid.addWidget(figure, row, 1)
        grid.setColumnStretch(1, 1)
        self.retranslate()

    @property
    def disk(self) -> str:
        """The free space that is shown."""
        return self._disk.text()

    @property
    def calibration(self) -> str:
        """The calibration that is shown."""
        return self._calibration.whole

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self._disk_title.setText(self.tr("Free disk"))
        self._calibration_title.setText(self.tr("Calibration"))
        self.show_facts(self._report)

    def show_facts(self, report: HealthReport) -> None:
        """Show what the nodes report."""
        self._report = report
        free_mb = report.free_disk_mb
        self._disk.setText(
            UNKNOWN if free_mb is None else f"{free_mb / MEGABYTES_PER_GIGABYTE:.1f} GB"
        )
        status = CalibrationStatus.named(report.calibration)
        known = report.calibration if status is None else shown_text(status.meaning)
        self._calibration.show_text(known or UNKNOWN)


def _scrolled(panel: QWidget) -> QScrollArea:
    """Return an area that scrolls where a panel is higher, as with many sensors."""
    area = QScrollArea()
    area.setWidget(panel)
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    return area


class StatusView(TranslatedWidget):
    """Two pages: what the robot does, and the health of its parts."""

    def __init__(self) -> None:
        super().__init__()
        self.message = MessagePanel()
        self.progress = ProgressPanel()
        self.positions = PositionPanel()
        self.facts = FactsPanel()
        self.health = HealthPanel()
        self.robot_button = new_button(lambda: self._show(0))
        self.parts_button = new_button(lambda: self._show(1))
        robot = QWidget()
        column = QVBoxLayout(robot)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.message, 1)
        for panel in (self.progress, self.positions, self.facts):
            column.addWidget(panel)
        self._pages = QStackedWidget()
        self._pages.addWidget(robot)
        self._pages.addWidget(_scrolled(self.health))
        side = QVBoxLayout()
        for button in (self.robot_button, self.parts_button):
            button.setCheckable(True)
            side.addWidget(button)
        side.addStretch(1)
        self._side = side
        self._layout = QHBoxLayout(self)
        self._layout.addWidget(self._pages, 1)
        self._layout.addLayout(side)
        self._show(0)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.robot_button.setText(self.tr("ROBOT"))
        self.parts_button.setText(self.tr("PARTS"))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
        self._layout.setSpacing(gap_px)
        self._side.setSpacing(gap_px)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self.message.show_state(snapshot.state)
        self.progress.show_progress(snapshot.progress, time_passes(snapshot))
        self.positions.refresh(snapshot)
        self.facts.show_facts(snapshot.health)
        self.health.show_health(snapshot.health)

    def _show(self, page: int) -> None:
        self._pages.setCurrentIndex(page)
        self.robot_button.setChecked(page == 0)
        self.parts_button.setChecked(page == 1)
