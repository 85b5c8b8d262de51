"""The lines of SERVICE for the axes: where each is, its endstop, and the buttons to move it."""

from __future__ import annotations

from typing import Callable, List, Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QLabel, QPushButton, QWidget

from gpr20_operator.robot.service_events import AxisAction
from gpr20_operator.robot.service_model import STEPS, AxisState, ServiceState
from gpr20_survey.axes.axis_id import AxisId
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.widgets import set_look

UNKNOWN = "—"
DISTANCES = (*(-step for step in reversed(STEPS)), *STEPS)
PLACE_PX = 110

# Called with an axis, what it is asked for, and a distance.
Move = Callable[[AxisId, AxisAction, float], None]


class AxisRow:
    """The line of one axis."""

    def __init__(self, axis: AxisId, move: Move) -> None:
        self.axis = axis
        self.place = QLabel(UNKNOWN)
        self.place.setObjectName("figure")
        self.lamp = QLabel()
        self.lamp.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.home = HoldButton()
        self.home.held.connect(lambda: move(axis, AxisAction.HOME, 0.0))
        self.set_zero: Optional[HoldButton] = None
        if axis is AxisId.Z:
            # Instead of the lamp of an endstop.
            self.set_zero = HoldButton()
            self.set_zero.held.connect(lambda: move(axis, AxisAction.SET_ZERO, 0.0))
        self.jogs = [self._jog_button(distance, move) for distance in DISTANCES]

    @property
    def buttons(self) -> List[QPushButton]:
        """All buttons of the line."""
        zero = [] if self.set_zero is None else [self.set_zero]
        return [*self.jogs, *zero, self.home]

    def _jog_button(self, distance: int, move: Move) -> HoldButton:
        button = HoldButton(f"{distance:+d}")
        button.setObjectName("jog")
        button.held.connect(lambda: move(self.axis, AxisAction.JOG, float(distance)))
        return button


class AxisRows(TranslatedWidget):
    """X, Y and Z, one below the other."""

    def __init__(self, move: Move) -> None:
        super().__init__()
        self._state: Optional[ServiceState] = None
        self.rows = [AxisRow(axis, move) for axis in AxisId]
        self._place_title, self._endstop_title, self._jog_title = QLabel(), QLabel(), QLabel()
        for title in (self._endstop_title, self._jog_title):
            title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.addWidget(self._place_title, 0, 0)
        self._grid.addWidget(self._endstop_title, 0, 1)
        self._grid.addWidget(self._jog_title, 0, 2, 1, len(DISTANCES))
        for line, row in enumerate(self.rows, 1):
            self._grid.addWidget(row.place, line, 0)
            beside: QWidget = row.lamp if row.set_zero is None else row.set_zero
            self._grid.addWidget(beside, line, 1)
            for column, button in enumerate(row.jogs, 2):
                self._grid.addWidget(button, line, column)
            self._grid.addWidget(row.home, line, 2 + len(DISTANCES))
        self._grid.setColumnStretch(1, 1)
        self._grid.setRowStretch(1 + len(self.rows), 1)
        self.restyle()
        self.retranslate()

    def row(self, axis: AxisId) -> AxisRow:
        """Return the line of an axis."""
        return next(row for row in self.rows if row.axis is axis)

    def show_state(self, state: ServiceState) -> None:
        """Show what is known of the axes."""
        if state == self._state:
            return
        self._state = state
        for row, axis in zip(self.rows, state.axes):
            self._show(row, axis)
            for button in row.buttons:
                button.setEnabled(state.entered and not state.busy)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        px = look_of(self).px
        self._grid.setSpacing(px(GAP_PX))
        self._grid.setColumnMinimumWidth(0, px(PLACE_PX))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self._place_title.setText(self.tr("mm (Z: °)"))
        self._endstop_title.setText(self.tr("Endstop"))
        self._jog_title.setText(self.tr("Move by mm (Z: °)"))
        for row in self.rows:
            row.home.setText(self.tr("HOME"))
            if row.set_zero is not None:
                row.set_zero.setText(self.tr("SET ZERO"))
        state, self._state = self._state, None
        if state is not None:
            self.show_state(state)

    def _show(self, row: AxisRow, state: AxisState) -> None:
        name = state.axis.value.upper()
        if state.homed is False:
            place = self.tr("not homed")
        elif state.coordinate is None:
            place = UNKNOWN
        elif state.axis is AxisId.Z:
            place = f"{state.coordinate:.1f}"
        else:
            place = f"{state.coordinate:.2f}"
        row.place.setText(f"{name} {place}")
        set_look(row.lamp, "lamp", "on" if state.pressed else "off")
        row.lamp.setText(self._lamp_text(state.pressed))

    def _lamp_text(self, pressed: Optional[bool]) -> str:
        if pressed is None:
            return UNKNOWN
        return "● " + self.tr("closed") if pressed else "○ " + self.tr("open")
