"""The first screen of ROBOT: what is wrong, the worst first, and a tile for each part."""

from __future__ import annotations

import html
from functools import partial
from typing import Dict, List, Optional, Tuple

from PyQt5.QtCore import QSize, Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth, node_title
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_user_interface.look.icons import icon
from gpr20_user_interface.look.look import GAP_PX, TextColours, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.widgets import (
    fill,
    in_two_lines,
    new_button,
    scroll_area,
    set_look,
    space,
)

FINDING_COLOURS: Dict[Level, TextColours] = {
    Level.OK: TextColours.GOOD,
    Level.NOTE: TextColours.REST,
    # It may be good or bad: never the colour of what is good or does not matter.
    Level.UNKNOWN: TextColours.DOUBTFUL,
    Level.WARNING: TextColours.DOUBTFUL,
    Level.FAULT: TextColours.BAD,
}
# The look of a part's tile, its sign, and the colours of both.
PART_LOOKS: Dict[HealthLevel, Tuple[str, str, TextColours]] = {
    HealthLevel.OK: ("good", "check", TextColours.ARROW),
    HealthLevel.WARN: ("doubtful", "warning", TextColours.DOUBTFUL),
    HealthLevel.ERROR: ("bad", "fault", TextColours.BAD),
    HealthLevel.STALE: ("bad", "fault", TextColours.BAD),
}
COLUMNS = 4
SIGN_PX = 22
LEVEL_PX = 100
ENTER_PX = 220


class PartTiles(TranslatedWidget):
    """A tile for each part of the robot: its name, on the colour and with the sign of its health.

    A gloved finger opens all that the part reports.
    """

    # Carries the NodeHealth that was touched.
    part_touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._report = HealthReport()
        self._tiles: List[QPushButton] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)

    def tile(self, name: str) -> QPushButton:
        """Return the tile of a node."""
        names = [node.name for node in self._report.nodes]
        return self._tiles[names.index(name)]

    def show_health(self, report: HealthReport) -> None:
        """Show the health of everything."""
        shown = [(one.name, one.level) for one in self._report.nodes]
        self._report = report
        if shown != [(one.name, one.level) for one in report.nodes]:
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        nodes = self._report.nodes
        while len(self._tiles) < len(nodes):
            number = len(self._tiles)
            tile = new_button(partial(self._touch, number))
            tile.setObjectName("part")
            self._tiles.append(tile)
            self._grid.addWidget(tile, *divmod(number, COLUMNS))
            self._grid.setColumnStretch(number % COLUMNS, 1)
        for number, tile in enumerate(self._tiles):
            tile.setVisible(number < len(nodes))
        for tile, node in zip(self._tiles, nodes):
            self._show(tile, node)

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        self._grid.setSpacing(look_of(self).px(GAP_PX))
        self.retranslate()

    def _touch(self, number: int) -> None:
        self.part_touched.emit(self._report.nodes[number])

    def _show(self, tile: QPushButton, node: NodeHealth) -> None:
        look, name, colours = PART_LOOKS[node.level]
        set_look(tile, "level", look)
        size_px = look_of(self).px(SIGN_PX)
        tile.setIcon(icon(name, look_of(self).text(colours).ink, size_px))
        tile.setIconSize(QSize(size_px, size_px))
        room_px = self.width() // COLUMNS - 2 * size_px
        tile.setText(in_two_lines(shown_text(node_title(node.name)), tile, room_px))


class Overview(TranslatedWidget):
    """What is wrong and the parts; below them the ways to find out more, and to the service."""

    # The operator has held the button that begins the service.
    entered = pyqtSignal()
    check_requested = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._findings: Tuple[Finding, ...] = ()
        self._model: Optional[ServiceModel] = None
        self._folded = True
        self.headline = QLabel()
        self.headline.setObjectName("title")
        self.headline.setWordWrap(True)
        self.findings, self.parts = QLabel(), PartTiles()
        self.findings.setTextFormat(Qt.TextFormat.RichText)
        self.findings.setWordWrap(True)
        self._parts_title, self.hint = QLabel(), QLabel()
        self._parts_title.setObjectName("title")
        self.hint.setObjectName("quiet")
        self.hint.setWordWrap(True)
        self.fold_button = new_button(self._on_fold)
        self.fold_button.setObjectName("choice")
        self.check_button = new_button(self.check_requested.emit)
        self.enter_button = HoldButton()
        self.enter_button.held.connect(self.entered)
        self._lay_out()
        self.retranslate()

    @property
    def listed(self) -> List[Finding]:
        """The findings that are listed: what is wrong or not known, or every check."""
        return [one for one in self._findings if not self._folded or one.level >= Level.UNKNOWN]

    def show_findings(self, findings: Tuple[Finding, ...]) -> None:
        """Show what is wrong with the robot; most times it is the same as before."""
        if findings != self._findings:
            self._findings = findings
            self._write_findings()

    def show_model(self, model: ServiceModel) -> None:
        """Show whether the robot can be serviced now."""
        self._model, obstacle = model, model.obstacle
        self.enter_button.setEnabled(obstacle is None)
        hint = self.tr(
            "Service moves single axes and tests the instruments: keep hands and cables clear."
        )
        self.hint.setText(hint if obstacle is None else shown_text(obstacle))
        self.check_button.setEnabled(not model.examining)
        self._write_counts()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self._parts_title.setText(self.tr("Parts"))
        self.enter_button.setText(self.tr("HOLD FOR SERVICE"))
        self._write_findings()
        if self._model is not None:
            self.show_model(self._model)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self.enter_button.setMinimumWidth(look_of(self).px(ENTER_PX))
        space(self, self._layout, self._top, self._bottom, self._content)
        self._write_findings()

    def _write_findings(self) -> None:
        look = look_of(self)
        rows = []
        for one in self.listed:
            pair = look.text(FINDING_COLOURS[one.level])
            lines = [one.text] if one.remedy is None else [one.text, one.remedy]
            text = "<br>".join(html.escape(shown_text(line)) for line in lines)
            level = html.escape(shown_text(one.level.title))
            rows.append(
                f'<tr><td width="{look.px(LEVEL_PX)}" align="center" bgcolor="{pair.ground}">'
                f'<font color="{pair.ink}">{level}</font></td><td>{text}</td></tr>'
            )
        table = f'<table cellpadding="{look.px(4)}">{"".join(rows)}</table>'
        self.findings.setText(table if rows else "")
        self.findings.setVisible(bool(rows))
        self._write_counts()

    def _write_counts(self) -> None:
        levels = [one.level for one in self._findings]
        wrong = sum(level >= Level.WARNING for level in levels)
        unknown = levels.count(Level.UNKNOWN)
        if not levels:
            headline = self.tr("The checks have not ended yet.")
        elif wrong:
            headline = self.tr("To do: {count}").format(count=wrong)
        elif unknown:
            headline = self.tr("No fault found, but not known: {count}").format(count=unknown)
        else:
            headline = self.tr("The checks have found no fault.")
        self.headline.setText(headline)
        good = self.tr("{good} checks good").format(good=levels.count(Level.OK))
        if Level.NOTE in levels:
            good += "\n" + self.tr("{count} notes").format(count=levels.count(Level.NOTE))
        self.fold_button.setText(good if self._folded else self.tr("Only what is wrong"))
        examining = self._model is not None and self._model.examining
        self.check_button.setText(self.tr("CHECKING") if examining else self.tr("CHECK ALL"))

    def _on_fold(self) -> None:
        self._folded = not self._folded
        self._write_findings()

    def _lay_out(self) -> None:
        content = QWidget()
        self._content = QVBoxLayout(content)
        self._content.setContentsMargins(0, 0, 0, 0)
        fill(self._content, self.findings, self._parts_title, self.parts)
        self._content.addStretch(1)
        words = QVBoxLayout()
        fill(words, self.headline, self.hint)
        # Not at the bottom, where sheets are closed: a second touch must not begin the service.
        self._top, self._bottom, self._layout = QHBoxLayout(), QHBoxLayout(), QVBoxLayout(self)
        fill(self._top, (words, 2), (self.enter_button, 1))
        fill(self._bottom, (self.fold_button, 1), (self.check_button, 1))
        fill(self._layout, self._top, (scroll_area(content), 1), self._bottom)
