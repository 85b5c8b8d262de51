"""Health of the nodes: a tile for each, which a gloved finger opens."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QFrame, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout

from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_doctor.mid.titles import level_title, node_title
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.notices import node_text
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.widgets.labels import ElidedLabel
from gpr20_user_interface.widgets.widgets import set_look

LOOKS: Dict[HealthLevel, str] = {
    HealthLevel.OK: "good",
    HealthLevel.WARN: "doubtful",
    HealthLevel.ERROR: "bad",
    HealthLevel.STALE: "bad",
}
COLUMNS = 2


class HealthPanel(TranslatedWidget):
    """One tile per node: its name, its health, and its message; a touch opens all of it."""

    # Carries the NodeHealth that was touched.
    node_touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._report = HealthReport()
        self._tiles: List[HealthTile] = []
        self._grid = QGridLayout(self)

    def texts(self, node: str) -> str:
        """Return the level and the message that are shown for a node."""
        tile = self.tile(node)
        return f"{tile.level.text()}: {tile.message.whole}"

    def tile(self, node: str) -> HealthTile:
        """Return the tile of a node."""
        return next(tile for tile in self._tiles if tile.node and tile.node.name == node)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        for tile in self._tiles:
            tile.forget()
        self.show_health(self._report)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(gap_px)

    def show_health(self, report: HealthReport) -> None:
        """Show the health of everything."""
        self._report = report
        while len(self._tiles) < len(report.nodes):
            row, column = divmod(len(self._tiles), COLUMNS)
            tile = HealthTile()
            tile.touched.connect(self.node_touched)
            self._grid.addWidget(tile, row, column)
            self._tiles.append(tile)
        for number, tile in enumerate(self._tiles):
            tile.setVisible(number < len(report.nodes))
        for tile, node in zip(self._tiles, report.nodes):
            tile.show_node(node)


class HealthTile(QFrame):
    """The tile of a node: its name and its health, its message below."""

    # Carries the NodeHealth.
    touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("tile")
        self.node: Optional[NodeHealth] = None
        self._shown: Optional[Tuple[str, HealthLevel, Message]] = None
        self.name, self.level, self.message = ElidedLabel(), QLabel(), ElidedLabel()
        self.name.setObjectName("tile_title")
        first = QHBoxLayout()
        first.addWidget(self.name, 1)
        first.addWidget(self.level)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 2, 6, 2)
        layout.setSpacing(0)
        layout.addLayout(first)
        layout.addWidget(self.message)

    def forget(self) -> None:
        """Write the texts again with the next report."""
        self._shown = None

    def show_node(self, node: NodeHealth) -> None:
        """Show the health of a node."""
        self.node = node
        shown = node.name, node.level, node_text(node)
        # Most reports repeat the last one, with other values.
        if shown == self._shown:
            return
        self._shown = shown
        self.name.show_text(shown_text(node_title(node.name)))
        # A label measures its text when it is set.
        set_look(self.level, "level", LOOKS[node.level])
        self.level.setText(shown_text(level_title(node.level)))
        self.message.show_text(sentence_text(node_text(node)))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the tile, or a label on it."""
        super().mouseReleaseEvent(event)
        if self.node is not None and self.rect().contains(event.pos()):
            self.touched.emit(self.node)
