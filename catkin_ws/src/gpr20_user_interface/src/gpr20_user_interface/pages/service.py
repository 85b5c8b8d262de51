"""The second screen of ROBOT: single axes, and tests of the instruments; behind a hold."""

from __future__ import annotations

import math
from functools import partial
from typing import Dict, List

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QLabel, QPushButton, QStackedWidget, QWidget

from gpr20_common.message import Message, verbatim
from gpr20_operator.jobs.job import Job
from gpr20_operator.robot.condition import first_step
from gpr20_operator.robot.service_model import PARTS, STEPS, AxisAction, HeightTested, ServiceModel
from gpr20_survey.axes import AxisId
from gpr20_survey.results.answers import INSTRUCTIONS, AnalyzerTest
from gpr20_survey.trace.sweep import CalibrationStatus
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_number, shown_text
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.widgets import (
    PulledText,
    column,
    grid,
    holding,
    new_button,
    new_label,
    row,
    say,
    set_look,
)

UNKNOWN = "—"
DISTANCES = (*(-step for step in reversed(STEPS)), *STEPS)
LAMPS = {
    None: Message("endstop {state}", state=UNKNOWN),
    True: Message("● closed"),
    False: Message("○ open"),
}


class ServiceScreen(QWidget):
    """Axes or instruments; below them the last answer, and the way back.

    Attributes:
        moves: The buttons of each axis: its distances, HOME, and SET ZERO instead of an endstop.
        answers: What each test of an instrument says.
    """

    # Carries AxisId, AxisAction and the distance.
    move_requested = pyqtSignal(object, object, float)
    left = pyqtSignal()
    # The operator looks at the other page.
    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.moves: Dict[AxisId, List[HoldButton]] = {axis: [] for axis in AxisId}
        self.places = {axis: new_label("figure") for axis in AxisId}
        self.lamps = {axis: QLabel() for axis in (AxisId.X, AxisId.Y)}
        self.measure, self.analyzer, self.daily = QPushButton(), QPushButton(), QPushButton()
        tests = self.measure, self.analyzer, self.daily
        self.answers: Dict[QPushButton, PulledText] = {one: PulledText() for one in tests}
        self.outcome = new_label(wraps=True)
        self.switch_button = new_button(self._on_switch)
        leave_button = new_button(self.left.emit)
        for button, text in (
            (self.measure, Message("MEASURE HEIGHT")),
            (self.analyzer, Message("TEST VNA")),
            (leave_button, Message("END SERVICE")),
        ):
            say(button, text)
        self._pages = QStackedWidget()
        for layout in (self._axes(), self._instruments()):
            self._pages.addWidget(holding(layout))
        bottom = row((self.outcome, 1), self.switch_button, leave_button)
        self.setLayout(column((self._pages, 1), bottom, margin=GAP_PX))
        self.begin()

    def begin(self) -> None:
        """Show the axes first."""
        self._show(0)

    def show_model(self, model: ServiceModel) -> None:
        """Show what is known now."""
        free = model.entered and not model.busy
        for axis in AxisId:
            self._show_axis(axis, model)
            for button in self.moves[axis]:
                button.setEnabled(free)
        text = Message("DAILY\nCHECK")
        if model.part is not None:
            number = PARTS.index(model.part) + 1
            text = Message("MEASURE\n{number}/{total}", number=number, total=len(PARTS))
        say(self.daily, text)
        lines = {
            self.measure: _height_lines(model.height),
            self.analyzer: _analyzer_lines(model),
            self.daily: _daily_lines(model),
        }
        for one, said in lines.items():
            one.setEnabled(free)
            self.answers[one].setText("\n".join(map(shown_text, said)))
        self.outcome.setText("" if model.outcome is None else shown_text(model.outcome))
        set_look(self.outcome, "level", "wrong" if model.failed else "")

    def _show_axis(self, axis: AxisId, model: ServiceModel) -> None:
        report, place = model.axis(axis), UNKNOWN
        if report is not None and report.homed:
            form, unit = (".1f", "°") if axis is AxisId.Z else (".2f", " mm")
            place = shown_number(report.coordinate, form) + unit
        elif report is not None:
            place = self.tr("not homed")
        self.places[axis].setText(f"{axis.value.upper()} {place}")
        if axis in self.lamps:
            pressed = model.pressed(axis)
            set_look(self.lamps[axis], "lamp", "on" if pressed else "off")
            say(self.lamps[axis], LAMPS[pressed])

    def _axes(self) -> QGridLayout:
        """Return X, Y and Z, one below the other; then the zero of Z."""
        layout = grid()
        for line, axis in enumerate(AxisId):
            words = [self.places[axis], *([self.lamps[axis]] if axis in self.lamps else [])]
            layout.addLayout(column(*words, gap=0), line, 0)
            unit = "°" if axis is AxisId.Z else ""
            for place, distance in enumerate(DISTANCES, 1):
                jog = self._move(axis, AxisAction.JOG, verbatim(f"{distance:+d}{unit}"), distance)
                layout.addWidget(jog, line, place)
            home = self._move(axis, AxisAction.HOME, Message("HOME"))
            layout.addWidget(home, line, len(DISTANCES) + 1)
        hint = new_label(wraps=True, text=Message("Z: turn the antennas to their mark first"))
        zero = self._move(AxisId.Z, AxisAction.SET_ZERO, Message("SET ZERO"))
        layout.addWidget(hint, len(AxisId), 0, 1, len(DISTANCES) - 1)
        layout.addWidget(zero, len(AxisId), len(DISTANCES), 1, 2)
        layout.setColumnStretch(0, 1)
        layout.setRowStretch(len(AxisId) + 1, 1)
        return layout

    def _move(
        self, axis: AxisId, action: AxisAction, text: Message, distance: float = 0.0
    ) -> HoldButton:
        button = HoldButton()
        button.setObjectName("jog")
        say(button, text)
        button.held.connect(partial(self.move_requested.emit, axis, action, float(distance)))
        self.moves[axis].append(button)
        return button

    def _instruments(self) -> QGridLayout:
        """Return a button for each test, and what came back."""
        layout = grid()
        for place, (button, answer) in enumerate(self.answers.items()):
            layout.addWidget(button, 0, place)
            layout.addWidget(answer, 1, place)
            layout.setColumnStretch(place, 1)
        layout.setRowStretch(1, 1)
        return layout

    def _on_switch(self) -> None:
        self._show(1 - self._pages.currentIndex())
        self.touched.emit()

    def _show(self, page: int) -> None:
        self._pages.setCurrentIndex(page)
        say(self.switch_button, Message("AXES") if page else Message("INSTRUMENTS"))


def _daily_lines(model: ServiceModel) -> List[Message]:
    if model.daily.running:
        return [Message("Measuring")]
    answer = model.daily.problem or model.daily.result
    lines = [] if answer is None else _with_step(answer)
    if model.part is not None:
        lines.append(INSTRUCTIONS[model.part])
    return lines or [Message("Compares the radar with its reference.")]


def _height_lines(job: Job[HeightTested]) -> List[Message]:
    height = job.result
    if job.problem is not None:
        return [job.problem]
    if height is None:
        return [Message("Measures the height of the antennas once.")]
    lines = []
    if height.failure is None:
        known = {"height_m": height.height_m, "spread_m": height.spread_m}
        lines.append(Message("Height {height_m:.3f} m ± {spread_m:.3f} m", **known))
    if math.isfinite(height.voltage_v):
        lines.append(Message("Sensor {voltage_v:.3f} V", voltage_v=height.voltage_v))
    return lines if height.failure is None else [*lines, height.failure]


def _analyzer_lines(model: ServiceModel) -> List[Message]:
    test = model.tested
    if test is None:
        return [Message("Connects, reads the calibration and takes a sweep.")]
    lines = []
    if test.identity:
        lines += [Message("Connected to {address}", address=test.address), verbatim(test.identity)]
    calibration = CalibrationStatus.__members__.get(test.calibration)
    if calibration is not None:
        lines.append(Message("Calibration: {state}", state=calibration.meaning))
    if test.points:
        lines.append(_sweep(test))
    if test.failure is not None:
        failed, *step = _with_step(test.failure)
        lines += [Message("FAULT: {reason}", reason=failed), *step]
    return lines


def _sweep(test: AnalyzerTest) -> Message:
    return Message(
        "Sweep of {points} points: {duration_s:.3f} s, {level_db:.0f} dB",
        points=test.points,
        duration_s=test.sweep_duration_s,
        level_db=test.level_db,
    )


def _with_step(said: Message) -> List[Message]:
    """Return a sentence, and what to do first."""
    first = first_step(said)
    return [said] if first is None else [said, first]
