"""The SERVICE tab: what is wrong with the robot; behind a hold, its axes and instruments."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from gpr20_doctor.mid.finding import Finding, Level
from gpr20_operator.robot.service_events import AxisAction
from gpr20_operator.robot.service_model import ServiceState
from gpr20_survey.axes.axis_id import AxisId
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.pages.service.axes import AxisRows
from gpr20_user_interface.pages.service.tools import ServiceTools
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.widgets import new_button, set_look

LOOKS: Dict[Level, str] = {
    Level.OK: "good",
    Level.NOTE: "",
    Level.UNKNOWN: "",
    Level.WARNING: "doubtful",
    Level.FAULT: "bad",
}


class DoctorList(TranslatedWidget):
    """One line per finding, the worst first: its level, its sentence, and the remedy below."""

    def __init__(self) -> None:
        super().__init__()
        self._findings: Tuple[Finding, ...] = ()
        self._rows: List[Tuple[QLabel, QLabel]] = []
        self._list = QWidget()
        self._grid = QGridLayout(self._list)
        self._grid.setContentsMargins(0, 0, GAP_PX, 0)
        self._grid.setSpacing(GAP_PX)
        self._grid.setColumnStretch(1, 1)
        area = QScrollArea()
        area.setWidget(self._list)
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(area)

    @property
    def texts(self) -> List[str]:
        """The lines that are shown."""
        rows = self._rows[: len(self._findings)]
        return [f"{level.text()}: {text.text()}" for level, text in rows]

    def show_findings(self, findings: Tuple[Finding, ...]) -> None:
        """Show findings; most times they are the last ones."""
        if findings != self._findings:
            self._findings = findings
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        while len(self._rows) < len(self._findings):
            self._add_row()
        for number, (level, text) in enumerate(self._rows):
            used = number < len(self._findings)
            level.setVisible(used)
            text.setVisible(used)
            if used:
                self._show(self._findings[number], level, text)

    def _add_row(self) -> None:
        level, text = QLabel(), QLabel()
        level.setAlignment(Qt.AlignmentFlag.AlignCenter)
        text.setWordWrap(True)
        row = len(self._rows)
        self._grid.addWidget(level, row, 0, Qt.AlignmentFlag.AlignTop)
        self._grid.addWidget(text, row, 1)
        self._grid.setRowStretch(row, 0)
        self._grid.setRowStretch(row + 1, 1)
        self._rows.append((level, text))

    @staticmethod
    def _show(finding: Finding, level: QLabel, text: QLabel) -> None:
        # First: the width of the text counts with the padding of its look.
        set_look(level, "level", LOOKS[finding.level])
        level.setText(shown_text(finding.level.title))
        lines = [finding.text] if finding.remedy is None else [finding.text, finding.remedy]
        text.setText("\n".join(map(shown_text, lines)))


SIDE_PX = 210


class ServiceView(TranslatedWidget):
    """The list of findings; in service, pages for axes and instruments."""

    # The operator has held the button that begins the service.
    entered = pyqtSignal()
    left = pyqtSignal()
    # Carries AxisId, AxisAction and the distance.
    move_requested = pyqtSignal(object, object, float)
    height_requested = pyqtSignal()
    test_requested = pyqtSignal()
    daily_check_requested = pyqtSignal()
    check_requested = pyqtSignal()
    # The operator looks at another page.
    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._state: Optional[ServiceState] = None
        self.doctor = DoctorList()
        self.enter_button = HoldButton()
        self.enter_button.held.connect(self.entered)
        self.check_button = new_button(self.check_requested.emit)
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        self.axes = AxisRows(self._on_move)
        self.tools = ServiceTools(
            self.height_requested.emit,
            self.test_requested.emit,
            self.daily_check_requested.emit,
        )
        self.outcome = QLabel()
        self.outcome.setWordWrap(True)
        self.switch_button = new_button(self._on_switch)
        self.leave_button = new_button(self.left.emit)
        self._pages = QStackedWidget()
        self._locked = QHBoxLayout()
        self._page = self._service_page()
        self._pages.addWidget(self._locked_page())
        self._pages.addWidget(self._page)
        self._layout = QVBoxLayout(self)
        self._layout.addWidget(self._pages)
        self.restyle()
        self.retranslate()

    @property
    def in_service(self) -> bool:
        """Whether the axes can be moved from here."""
        return self._pages.currentWidget() is self._page

    def show_state(self, state: ServiceState) -> None:
        """Show what is known now."""
        if state == self._state:
            return
        self._state = state
        if state.entered != self.in_service:
            self._tools_pages.setCurrentWidget(self.axes)
            self._pages.setCurrentIndex(int(state.entered))
            self._write_switch()
        self.enter_button.setEnabled(state.obstacle is None)
        self.hint.setText(self._hint(state))
        self.check_button.setEnabled(not state.examining)
        self._write_check(state.examining)
        self.axes.show_state(state)
        self.tools.show_state(state)
        self.outcome.setText("" if state.outcome is None else shown_text(state.outcome))
        set_look(self.outcome, "level", "wrong" if state.failed else "")

    def show_findings(self, findings: Tuple[Finding, ...]) -> None:
        """Show what is wrong with the robot."""
        self.doctor.show_findings(findings)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        px = look_of(self).px
        gap = px(GAP_PX)
        self._layout.setContentsMargins(gap, gap, gap, gap)
        self._locked.setSpacing(2 * gap)
        self.hint.setFixedWidth(px(SIDE_PX))
        self.enter_button.setFixedWidth(px(SIDE_PX))
        self.check_button.setFixedWidth(px(SIDE_PX))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.enter_button.setText(self.tr("BEGIN SERVICE"))
        self.leave_button.setText(self.tr("END SERVICE"))
        self._write_switch()
        self._write_check(False)
        state, self._state = self._state, None
        if state is not None:
            self.show_state(state)

    def _locked_page(self) -> QWidget:
        page = QWidget()
        side = QVBoxLayout()
        side.addWidget(self.enter_button)
        side.addWidget(self.hint)
        side.addStretch(1)
        side.addWidget(self.check_button)
        self._locked.addWidget(self.doctor, 1)
        self._locked.addLayout(side)
        self._locked.setContentsMargins(0, 0, 0, 0)
        page.setLayout(self._locked)
        return page

    def _service_page(self) -> QWidget:
        page = QWidget()
        self._tools_pages = QStackedWidget()
        self._tools_pages.addWidget(self.axes)
        self._tools_pages.addWidget(self.tools)
        bottom = QHBoxLayout()
        bottom.addWidget(self.outcome, 1)
        bottom.addWidget(self.switch_button)
        bottom.addWidget(self.leave_button)
        layout = QVBoxLayout(page)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._tools_pages, 1)
        layout.addLayout(bottom)
        return page

    def _hint(self, state: ServiceState) -> str:
        if state.obstacle is not None:
            return shown_text(state.obstacle)
        return self.tr(
            "Hold for 1 s. Service moves single axes and tests the instruments. Keep hands and "
            "cables clear of the robot."
        )

    def _on_move(self, axis: AxisId, action: AxisAction, distance: float) -> None:
        self.move_requested.emit(axis, action, distance)

    def _on_switch(self) -> None:
        others = {self.axes: self.tools, self.tools: self.axes}
        self._tools_pages.setCurrentWidget(others[self._tools_pages.currentWidget()])
        self._write_switch()
        self.touched.emit()

    def _write_check(self, examining: bool) -> None:
        text = self.tr("CHECKING") if examining else self.tr("CHECK ALL")
        self.check_button.setText(text)

    def _write_switch(self) -> None:
        on_axes = self._tools_pages.currentWidget() is self.axes
        self.switch_button.setText(self.tr("INSTRUMENTS") if on_axes else self.tr("AXES"))
