"""Health of the nodes, the VNA and the disk."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QGridLayout, QLabel, QTextEdit

from gpr20_common.message import Message
from gpr20_user_interface.mid.events import HealthLevel, NodeHealth
from gpr20_user_interface.mid.notices import node_text
from gpr20_user_interface.mid.robot_health import HealthReport
from gpr20_user_interface.mid.titles import level_title, node_title
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import set_look

UNKNOWN = "—"
LOOKS: Dict[HealthLevel, str] = {
    HealthLevel.OK: "good",
    HealthLevel.WARN: "doubtful",
    HealthLevel.ERROR: "bad",
    HealthLevel.STALE: "bad",
}
# The line of a node that does not report has no more text.
SHOWN_IN_FULL = (HealthLevel.WARN, HealthLevel.ERROR)
FIRST_ROW = 2
# As high as eight lines can be, so that a finger hits one.
ROW_PX = 28
# Below everything: takes the room that is left.
LAST_ROW = 100
MEGABYTES_PER_GIGABYTE = 1000.0


class HealthPanel(TranslatedWidget):
    """One line per node: its name, its health, and its message; a touch opens all of it."""

    # Carries the NodeHealth that was touched.
    node_touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._report = HealthReport()
        self._rows: List[HealthRow] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(6)
        self._grid.setVerticalSpacing(3)
        self._grid.setColumnStretch(2, 1)
        self._grid.setRowStretch(LAST_ROW, 1)
        self._disk_title, self._disk = QLabel(), QLabel()
        self._calibration_title, self._calibration = QLabel(), ElidedLabel()
        self._grid.addWidget(self._disk_title, 0, 0)
        self._grid.addWidget(self._disk, 0, 1, 1, 2)
        self._grid.addWidget(self._calibration_title, 1, 0)
        self._grid.addWidget(self._calibration, 1, 1, 1, 2)
        # A line has no room for a long sentence; warnings, faults and cut lines are shown here.
        self._details = QTextEdit()
        self._details.setReadOnly(True)
        self._details.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._grid.addWidget(self._details, LAST_ROW, 0, 1, 3)
        self.retranslate()

    def texts(self, node: str) -> str:
        """Return the level and the message that are shown for a node."""
        row = self.row(node)
        return f"{row.level.text()}: {row.message.whole}"

    def row(self, node: str) -> HealthRow:
        """Return the line of a node."""
        return next(row for row in self._rows if row.node is not None and row.node.name == node)

    @property
    def details(self) -> str:
        """The whole messages of nodes with a warning or fault, or whose line is cut."""
        return self._details.toPlainText()

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
        for row in self._rows:
            row.clear()
        self.show_health(self._report)

    def show_health(self, report: HealthReport) -> None:
        """Show the health of everything."""
        self._report = report
        while len(self._rows) < len(report.nodes):
            self._rows.append(HealthRow(len(self._rows), self._grid))
        for row in self._rows[len(report.nodes) :]:
            row.clear()
        for row, node in zip(self._rows, report.nodes):
            row.show(node)
        in_full = [
            node
            for row, node in zip(self._rows, report.nodes)
            if node.level in SHOWN_IN_FULL or row.message.is_cut
        ]
        details = "\n".join(
            f"{shown_text(node_title(node.name))}: {shown_text(node_text(node))}"
            # Faults first: the message of the main control, a warning, is the status as well.
            for node in sorted(in_full, key=lambda node: node.level, reverse=True)
        )
        if details != self.details:
            self._details.setPlainText(details)
        free_mb = report.free_disk_mb
        self._disk.setText(
            UNKNOWN if free_mb is None else f"{free_mb / MEGABYTES_PER_GIGABYTE:.1f} GB"
        )
        self._calibration.show_text(self._calibration_text(report.calibration))

    def _calibration_text(self, status: str) -> str:
        texts = {
            "NONE": self.tr("none"),
            "HIGH": self.tr("high accuracy"),
            "MODERATE_POWER": self.tr("moderate: power level changed"),
            "MODERATE_TEMPERATURE": self.tr("moderate: temperature changed"),
            "LOW": self.tr("low: temperature changed"),
        }
        return texts.get(status, status or UNKNOWN)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the list; the lines are its labels."""
        super().mouseReleaseEvent(event)
        for row in self._rows:
            if row.node is not None and row.top <= event.pos().y() <= row.bottom:
                self.node_touched.emit(row.node)
                return


class HealthRow:
    """The line of a node: its name, its health, and its message."""

    def __init__(self, number: int, grid: QGridLayout) -> None:
        self.node: Optional[NodeHealth] = None
        self.name, self.level, self.message = QLabel(), QLabel(), ElidedLabel()
        self.level.setAlignment(Qt.AlignmentFlag.AlignCenter)
        row = FIRST_ROW + number
        grid.setRowMinimumHeight(row, ROW_PX)
        for column, label in enumerate((self.name, self.level, self.message)):
            grid.addWidget(label, row, column)

    @property
    def top(self) -> int:
        """Upper edge in the panel [px]."""
        return self.level.geometry().top()

    @property
    def bottom(self) -> int:
        """Lower edge in the panel [px]."""
        return self.level.geometry().bottom()

    def clear(self) -> None:
        """Show nothing: fewer nodes are known."""
        self.node = None
        self.name.setText("")
        self.level.setText("")
        self.message.show_text("")
        set_look(self.level, "level", "")

    def show(self, node: NodeHealth) -> None:
        """Show the health of a node."""
        former, self.node = self.node, node
        # Most reports repeat the last one, with other values.
        if former is not None and _looks(former) == _looks(node):
            return
        self.name.setText(shown_text(node_title(node.name)))
        self.level.setText(shown_text(level_title(node.level)))
        set_look(self.level, "level", LOOKS[node.level])
        self.message.show_text(shown_text(node_text(node)))


def _looks(node: NodeHealth) -> Tuple[str, HealthLevel, Message]:
    """Return what the line of a node shows, in any language."""
    return node.name, node.level, node_text(node)
