"""ROBOT: what is wrong and a tile for each part; behind a hold, axes and instruments."""

from __future__ import annotations

import html
from typing import Callable, Dict, List, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QFrame, QScrollArea, QStackedWidget, QWidget

from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import HealthReport, NodeHealth, node_title
from gpr20_operator.robot.notices import Notice, node_notice
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import GAP_PX, TextColours, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.service import ServiceScreen
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.tile import TileButton
from gpr20_user_interface.widgets.widgets import (
    Page,
    column,
    grid,
    holding,
    new_button,
    new_label,
    offer,
    row,
    say,
    set_look,
)

# How a level is called in the style sheet, and its colours.
LEVEL_LOOKS: Dict[Level, Tuple[str, TextColours]] = {
    Level.OK: ("good", TextColours.GOOD),
    Level.NOTE: ("rest", TextColours.REST),
    # It may be good or bad: never the colour of what is good or does not matter.
    Level.UNKNOWN: ("doubtful", TextColours.DOUBTFUL),
    Level.WARNING: ("doubtful", TextColours.DOUBTFUL),
    Level.FAULT: ("bad", TextColours.BAD),
}
# The signs of the parts.
SIGNS: Dict[Level, str] = {
    Level.OK: "\N{CHECK MARK}",
    Level.NOTE: "\N{BULLET}",
    Level.WARNING: "\N{WARNING SIGN}",
    Level.FAULT: "\N{MULTIPLICATION X}",
}
COLUMNS = 4
LEVEL_PX = 100


class Overview(QWidget):
    """What is wrong, the worst first, and the parts; below them the ways to find out more."""

    # The operator has held the button that begins the service.
    entered = pyqtSignal()
    check_requested = pyqtSignal()
    # Carries the NodeHealth that was touched.
    part_touched = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._findings: Tuple[Finding, ...] = ()
        self._nodes: Tuple[NodeHealth, ...] = ()
        self.headline = new_label("title", wraps=True)
        self.hint = new_label("quiet", wraps=True)
        self.table = new_label(wraps=True)
        self.table.setTextFormat(Qt.TextFormat.RichText)
        self.tiles: List[TileButton] = []
        self._grid = grid()
        self.check_button = new_button(self.check_requested.emit)
        self.enter_button = HoldButton()
        say(self.enter_button, Message("HOLD FOR SERVICE"))
        self.enter_button.held.connect(self.entered)
        self._lay_out()
        self.show_findings(())

    @property
    def listed(self) -> List[Finding]:
        """The findings that are listed: what is wrong or not known."""
        return [one for one in self._findings if one.level >= Level.UNKNOWN]

    def show_findings(self, findings: Tuple[Finding, ...]) -> None:
        """Show what is wrong with the robot; most times it is the same as before."""
        self._findings = findings
        look, rows = look_of(self), []
        for one in self.listed:
            pair = look.text(LEVEL_LOOKS[one.level][1])
            lines = [one.text] if one.remedy is None else [one.text, one.remedy]
            text = "<br>".join(html.escape(shown_text(line)) for line in lines)
            level = html.escape(shown_text(one.level.title))
            rows.append(
                f'<tr><td width="{look.px(LEVEL_PX)}" align="center" bgcolor="{pair.ground}">'
                f'<font color="{pair.ink}">{level}</font></td><td>{text}</td></tr>'
            )
        table = f'<table cellpadding="{look.px(4)}">{"".join(rows)}</table>' if rows else ""
        if table != self.table.text():
            self.table.setText(table)
        self.table.setVisible(bool(rows))
        self._write_counts()

    def show_model(self, model: ServiceModel, report: HealthReport) -> None:
        """Show the parts, and whether the robot can be serviced now."""
        obstacle = model.obstacle
        self.enter_button.setEnabled(obstacle is None)
        keep = Message("Service moves single axes. Keep hands and cables clear.")
        say(self.hint, obstacle or keep)
        checking = Message("CHECKING") if model.examining else None
        offer(self.check_button, Message("CHECK ALL"), checking)
        self._nodes = report.nodes
        while len(self.tiles) < len(self._nodes):
            number = len(self.tiles)
            self.tiles.append(TileButton(lines=0))
            self.tiles[-1].sentence.setObjectName("small")
            self.tiles[-1].clicked.connect(lambda _checked, number=number: self._touch(number))
            self._grid.addWidget(self.tiles[-1], *divmod(number, COLUMNS))
            self._grid.setColumnStretch(number % COLUMNS, 1)
        for number, tile in enumerate(self.tiles):
            tile.setVisible(number < len(self._nodes))
        for tile, node in zip(self.tiles, self._nodes):
            name = f"{SIGNS[node.rating]} {shown_text(node_title(node.name))}"
            tile.show_texts("", sentence=name, level=LEVEL_LOOKS[node.rating][0])
        self._write_counts()

    def _touch(self, number: int) -> None:
        self.part_touched.emit(self._nodes[number])

    def _write_counts(self) -> None:
        """Say the worst of the checks and of the parts in a word, with its colour."""
        checks = [one.level for one in self._findings]
        parts = [node.rating for node in self._nodes]
        worst = max(checks + parts, default=Level.OK)
        if worst >= Level.UNKNOWN:
            count = max(checks.count(worst), parts.count(worst))
            say(self.headline, Message("{level}: {count}", level=worst.title, count=count))
        elif checks:
            say(self.headline, Message("The checks have found no fault."))
        else:
            say(self.headline, Message("The checks have not ended yet."))
        rated = bool(checks) or worst >= Level.UNKNOWN
        set_look(self.headline, "level", LEVEL_LOOKS[worst][0] if rated else "")

    def _lay_out(self) -> None:
        inside, area = column(self.table, self._grid), QScrollArea()
        inside.addStretch(1)
        area.setWidget(holding(inside))
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # Not at the bottom, where sheets are closed: a second touch must not begin the service.
        top = row((column(self.headline, self.hint), 2), (self.enter_button, 1))
        parts = (top, (area, 1), self.check_button)
        self.setLayout(column(*parts, margin=GAP_PX))


class RobotPage(QStackedWidget, Page):
    """Shows the robot while it is in front; leaving it ends the service."""

    def __init__(self, model: ServiceModel, show_notice: Callable[[Notice], None]) -> None:
        super().__init__()
        self._model = model
        self._watched = False
        self._report = HealthReport()
        self.overview, self.service = Overview(), ServiceScreen()
        for screen in (self.overview, self.service):
            self.addWidget(screen)
        self.overview.part_touched.connect(lambda node: show_notice(node_notice(node)))
        self.overview.entered.connect(lambda: self._after(model.enter))
        self.overview.check_requested.connect(lambda: self._after(model.check_everything))
        service = self.service
        service.left.connect(lambda: self._after(model.leave))
        service.touched.connect(model.touch)
        service.move_requested.connect(
            lambda axis, action, distance: self._after(lambda: model.move(axis, action, distance))
        )
        service.measure.clicked.connect(lambda: self._after(lambda: model.ask(model.height)))
        service.analyzer.clicked.connect(lambda: self._after(lambda: model.ask(model.analyzer)))
        service.daily.clicked.connect(lambda: self._after(model.check_daily))

    @property
    def in_service(self) -> bool:
        """Whether the axes can be moved from here."""
        return self.currentWidget() is self.service

    def on_event(self, event: object) -> None:
        """Take an event about the robot."""
        self._model.on_event(event)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show what is known now; end the service when another page is in front."""
        changed = self.isVisible() != self._watched
        if changed:
            self._watched = self.isVisible()
            self._model.set_watched(self._watched)
        self._model.refresh(snapshot)
        self._report = snapshot.health
        if self._watched or changed:
            self._show()
        if self._watched:
            self.overview.show_findings(self._model.findings())

    def _after(self, act: Callable[[], None]) -> None:
        """Do something, and show its effect at once: a second touch must not repeat it."""
        act()
        self._show()

    def _show(self) -> None:
        if self._model.entered != self.in_service:
            self.service.begin()
            self.setCurrentIndex(int(self._model.entered))
        self.overview.show_model(self._model, self._report)
        self.service.show_model(self._model)
