"""The SERVICE tab: what is wrong with the robot; behind a hold, its axes and instruments."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QStackedWidget, QVBoxLayout, QWidget

from gpr20_doctor.mid.finding import Finding
from gpr20_survey.axes.axis_id import AxisId
from gpr20_user_interface.mid.service_events import AxisAction
from gpr20_user_interface.mid.service_model import ServiceState
from gpr20_user_interface.views.axis_service_rows import AxisRows
from gpr20_user_interface.views.doctor_list import DoctorList
from gpr20_user_interface.views.hold_button import HoldButton
from gpr20_user_interface.views.look import GAP_PX, look_of
from gpr20_user_interface.views.service_tools import ServiceTools
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import new_button, set_look

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
