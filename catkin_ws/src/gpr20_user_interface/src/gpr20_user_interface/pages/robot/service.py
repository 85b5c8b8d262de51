"""The second screen of ROBOT: single axes, and tests of the instruments; behind a hold."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QStackedWidget,
    QTextEdit,
    QVBoxLayout,
    QWidget,
)

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.jobs.job import Job
from gpr20_operator.robot.condition import first_step
from gpr20_operator.robot.service_model import (
    PARTS,
    STEPS,
    AxisAction,
    HeightTested,
    ServiceModel,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import INSTRUCTIONS
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_number, shown_text
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.widgets import fill, in_two_lines, new_button, set_look, space

UNKNOWN = "—"
DISTANCES = (*(-step for step in reversed(STEPS)), *STEPS)
PLACE_PX = 130
# What the text of an instrument's button has room for.
BUTTON_PX = 190

# Called with an axis, what it is asked for, and a distance.
Move = Callable[[AxisId, AxisAction, float], None]


class AxisRow:
    """The line of one axis: where it is, its endstop, and the buttons to move it."""

    def __init__(self, axis: AxisId, move: Move) -> None:
        def button(text: str, action: AxisAction, distance: float = 0.0) -> HoldButton:
            new = HoldButton(text)
            new.held.connect(lambda: move(axis, action, distance))
            return new

        self.axis = axis
        self.place, self.lamp = QLabel(UNKNOWN), QLabel()
        self.place.setObjectName("figure")
        self.jogs = [button(f"{one:+d}", AxisAction.JOG, float(one)) for one in DISTANCES]
        for jog in self.jogs:
            jog.setObjectName("jog")
        self.home = button("", AxisAction.HOME)
        # Instead of an endstop.
        self.set_zero = button("", AxisAction.SET_ZERO) if axis is AxisId.Z else None

    @property
    def buttons(self) -> List[QPushButton]:
        """All buttons of the line."""
        zero = [] if self.set_zero is None else [self.set_zero]
        return [*self.jogs, *zero, self.home]


class AxisRows(TranslatedWidget):
    """X, Y and Z, one below the other; then the zero of Z."""

    def __init__(self, move: Move) -> None:
        super().__init__()
        self.rows = [AxisRow(axis, move) for axis in AxisId]
        self._zero_title = QLabel()
        self._zero_title.setWordWrap(True)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setColumnStretch(0, 1)
        for line, row in enumerate(self.rows):
            words = QVBoxLayout()
            words.setSpacing(0)
            fill(words, row.place, row.lamp)
            self._grid.addLayout(words, line, 0)
            for column, button in enumerate([*row.jogs, row.home], 1):
                self._grid.addWidget(button, line, column)
            if row.set_zero is not None:
                self._grid.addWidget(self._zero_title, line + 1, 0, 1, len(DISTANCES) - 1)
                self._grid.addWidget(row.set_zero, line + 1, len(DISTANCES), 1, 2)
        self._grid.setRowStretch(1 + len(self.rows), 1)
        self.restyle()
        self.retranslate()

    def row(self, axis: AxisId) -> AxisRow:
        """Return the line of an axis."""
        return next(row for row in self.rows if row.axis is axis)

    def show_model(self, model: ServiceModel) -> None:
        """Show what is known of the axes."""
        for row in self.rows:
            self._show(row, model.axis(row.axis), model.pressed(row.axis))
            for button in row.buttons:
                button.setEnabled(model.entered and not model.busy)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        px = look_of(self).px
        self._grid.setSpacing(px(GAP_PX))
        self._grid.setColumnMinimumWidth(0, px(PLACE_PX))

    def retranslate(self) -> None:
        self._zero_title.setText(self.tr("Z: turn the antennas to their mark first"))
        for row in self.rows:
            row.home.setText(self.tr("HOME"))
            if row.set_zero is not None:
                row.set_zero.setText(self.tr("SET ZERO"))

    def _show(self, row: AxisRow, report: Optional[AxisReport], pressed: Optional[bool]) -> None:
        place, turns = UNKNOWN, row.axis is AxisId.Z
        if report is not None and report.homed:
            form, unit = (".1f", "°") if turns else (".2f", " mm")
            place = shown_number(report.coordinate, form) + unit
        elif report is not None:
            place = self.tr("not homed")
        row.place.setText(f"{row.axis.value.upper()} {place}")
        set_look(row.lamp, "lamp", "on" if pressed else "off")
        lamp = {
            None: self.tr("endstop") + f" {UNKNOWN}",
            True: "● " + self.tr("closed"),
            False: "○ " + self.tr("open"),
        }[pressed]
        row.lamp.setText("" if turns else lamp)


class Instruments(TranslatedWidget):
    """Height sensor, VNA and daily check: for each a button, and what came back."""

    def __init__(self) -> None:
        super().__init__()
        self.measure, self.analyzer, self.daily = QPushButton(), QPushButton(), QPushButton()
        self.answers: Dict[QPushButton, QTextEdit] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        for column, button in enumerate((self.measure, self.analyzer, self.daily)):
            self.answers[button] = _text_area()
            self._grid.addWidget(button, 0, column)
            self._grid.addWidget(self.answers[button], 1, column)
            self._grid.setColumnStretch(column, 1)
        self._grid.setRowStretch(1, 1)
        self.restyle()
        self.retranslate()

    def show_model(self, model: ServiceModel) -> None:
        """Show what came back."""
        text = self.tr("DAILY CHECK")
        if model.part is not None:
            text = self.tr("MEASURE {number}/{total}").format(
                number=PARTS.index(model.part) + 1, total=len(PARTS)
            )
        self.daily.setText(in_two_lines(text, self.daily, look_of(self).px(BUTTON_PX)))
        texts = {
            self.measure: self._height_text(model.height),
            self.analyzer: self._analyzer_text(model.tested),
            self.daily: self._daily_text(model),
        }
        for button, text in texts.items():
            button.setEnabled(model.entered and not model.busy)
            # A text that is written again scrolls to its begin.
            if self.answers[button].toPlainText() != text:
                self.answers[button].setPlainText(text)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self._grid.setSpacing(look_of(self).px(GAP_PX))

    def retranslate(self) -> None:
        self.measure.setText(self.tr("MEASURE HEIGHT"))
        self.analyzer.setText(self.tr("TEST VNA"))

    def _daily_text(self, model: ServiceModel) -> str:
        if model.daily.running:
            return self.tr("Measuring")
        answer = model.daily.problem or model.daily.result
        lines = [] if answer is None else [answer, first_step(answer)]
        if model.part is not None:
            lines.append(INSTRUCTIONS[model.part])
        text = "\n".join(shown_text(line) for line in lines if line is not None)
        return text or self.tr("Compares the radar with its reference.")

    def _height_text(self, job: Job[HeightTested]) -> str:
        if job.problem is not None:
            return shown_text(job.problem)
        height = job.result
        if height is None:
            return self.tr("Measures the height of the antennas once.")
        lines = []
        if height.failure is None:
            known = {"height_m": height.height_m, "spread_m": height.spread_m}
            lines.append(Message("Height {height_m:.3f} m ± {spread_m:.3f} m", **known))
        if math.isfinite(height.voltage_v):
            lines.append(Message("Sensor {voltage_v:.3f} V", voltage_v=height.voltage_v))
        if height.failure is not None:
            lines.append(height.failure)
        return "\n".join(map(shown_text, lines))

    def _analyzer_text(self, test: Optional[AnalyzerTest]) -> str:
        if test is None:
            return self.tr("Connects, reads the calibration and takes a sweep.")
        lines = []
        if test.identity:
            lines.append(Message("Connected to {address}", address=test.address))
            lines.append(verbatim(test.identity))
        calibration = CalibrationStatus.__members__.get(test.calibration)
        if calibration is not None:
            lines.append(Message("Calibration: {state}", state=calibration.meaning))
        if test.points:
            sweep = Message(
                "Sweep of {points} points: {duration_s:.3f} s, {level_db:.0f} dB",
                points=test.points,
                duration_s=test.sweep_duration_s,
                level_db=test.level_db,
            )
            lines.append(sweep)
        if test.failure is not None:
            lines.append(Message("FAULT: {reason}", reason=test.failure))
            first = first_step(test.failure)
            lines += [] if first is None else [first]
        return "\n".join(map(shown_text, lines))


def _text_area() -> QTextEdit:
    """Return a text that scrolls: a failure may be long."""
    area = QTextEdit(UNKNOWN)
    area.setReadOnly(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return area


class ServiceScreen(TranslatedWidget):
    """Axes or instruments; below them the last answer, and the way back."""

    # Carries AxisId, AxisAction and the distance.
    move_requested = pyqtSignal(object, object, float)
    left = pyqtSignal()
    # The operator looks at the other page.
    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.axes, self.instruments = AxisRows(self.move_requested.emit), Instruments()
        self.outcome = QLabel()
        self.outcome.setWordWrap(True)
        self.switch_button = new_button(self._on_switch)
        self.leave_button = new_button(self.left.emit)
        self._pages = QStackedWidget()
        for page in (self.axes, self.instruments):
            self._pages.addWidget(page)
        self._bottom, self._layout = QHBoxLayout(), QVBoxLayout(self)
        fill(self._bottom, (self.outcome, 1), self.switch_button, self.leave_button)
        fill(self._layout, (self._pages, 1), self._bottom)
        self.retranslate()

    def begin(self) -> None:
        """Show the axes first."""
        self._show(self.axes)

    def show_model(self, model: ServiceModel) -> None:
        """Show what is known now."""
        self.axes.show_model(model)
        self.instruments.show_model(model)
        self.outcome.setText("" if model.outcome is None else shown_text(model.outcome))
        set_look(self.outcome, "level", "wrong" if model.failed else "")

    def restyle(self) -> None:
        """Take the sizes of the look."""
        space(self, self._layout, self._bottom)

    def retranslate(self) -> None:
        self.leave_button.setText(self.tr("END SERVICE"))
        on_axes = self._pages.currentWidget() is self.axes
        self.switch_button.setText(self.tr("INSTRUMENTS") if on_axes else self.tr("AXES"))

    def _on_switch(self) -> None:
        on_axes = self._pages.currentWidget() is self.axes
        self._show(self.instruments if on_axes else self.axes)
        self.touched.emit()

    def _show(self, page: QWidget) -> None:
        self._pages.setCurrentWidget(page)
        self.retranslate()
