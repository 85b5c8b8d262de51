"""How the nodes, the VNA and the disk are."""

from __future__ import annotations

from typing import Dict, List

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QLabel, QTextEdit

from gpr20_user_interface.mid.events import HealthLevel, NodeHealth
from gpr20_user_interface.mid.robot_health import HealthReport
from gpr20_user_interface.views.robot_text import robot_text
from gpr20_user_interface.views.style import set_look
from gpr20_user_interface.views.top_bar import ElidedLabel
from gpr20_user_interface.views.translation import TranslatedWidget

UNKNOWN = "—"
LOOKS: Dict[HealthLevel, str] = {
    HealthLevel.OK: "good",
    HealthLevel.WARN: "doubtful",
    HealthLevel.ERROR: "bad",
    HealthLevel.STALE: "bad",
}
# A node that is gone says nothing: its line tells it all.
TOLD_IN_FULL = (HealthLevel.WARN, HealthLevel.ERROR)
FIRST_ROW = 2
# Below everything: takes the room that is left.
LAST_ROW = 100
MEGABYTES_PER_GIGABYTE = 1000.0


class HealthPanel(TranslatedWidget):
    """One line per node: its name, how it is, and its own words."""

    def __init__(self) -> None:
        super().__init__()
        self._report = HealthReport()
        self._rows: List[_Row] = []
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
        # A line has no room for a long sentence; what is wrong, or cut, is read to its end here.
        self._details = QTextEdit()
        self._details.setReadOnly(True)
        self._details.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._grid.addWidget(self._details, LAST_ROW, 0, 1, 3)
        self.retranslate()

    def texts(self, node: str) -> str:
        """Return the level and the words that are shown for a node."""
        row = next(row for row in self._rows if row.node == node)
        return f"{row.level.text()}: {row.words.whole}"

    @property
    def details(self) -> str:
        """The whole sentences of the nodes that have trouble, or whose line is cut."""
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
        self.show_health(self._report)

    def show_health(self, report: HealthReport) -> None:
        """Show how everything is."""
        self._report = report
        for node in report.nodes[len(self._rows) :]:
            self._rows.append(_Row(len(self._rows), node.name, self._grid))
        for row, node in zip(self._rows, report.nodes):
            row.show(node, self._level_text(node.level), self._words(node))
        details = "\n".join(
            f"{_short_name(node)}: {self._words(node)}"
            for row, node in zip(self._rows, report.nodes)
            if node.level in TOLD_IN_FULL or row.words.is_cut
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
            "MODERATE_POWER": self.tr("moderate: other power level"),
            "MODERATE_TEMPERATURE": self.tr("moderate: temperature"),
            "LOW": self.tr("low: temperature"),
        }
        return texts.get(status, status or UNKNOWN)

    def _words(self, node: NodeHealth) -> str:
        if node.level is HealthLevel.STALE:
            return self.tr("not heard")
        return robot_text(node.message)

    def _level_text(self, level: HealthLevel) -> str:
        return {
            HealthLevel.OK: self.tr("OK"),
            HealthLevel.WARN: self.tr("LOOK"),
            HealthLevel.ERROR: self.tr("FAULT"),
            HealthLevel.STALE: self.tr("GONE"),
        }[level]


def _short_name(node: NodeHealth) -> str:
    return node.name.replace("/axis_driver", "")


class _Row:
    def __init__(self, number: int, node: str, grid: QGridLayout) -> None:
        self.node = node
        self.name, self.level, self.words = QLabel(), QLabel(), ElidedLabel()
        self.level.setAlignment(Qt.AlignmentFlag.AlignCenter)
        row = FIRST_ROW + number
        for column, label in enumerate((self.name, self.level, self.words)):
            grid.addWidget(label, row, column)

    def show(self, node: NodeHealth, level: str, words: str) -> None:
        self.node = node.name
        self.name.setText(_short_name(node))
        self.level.setText(level)
        set_look(self.level, "level", LOOKS[node.level])
        self.words.show_text(words)
