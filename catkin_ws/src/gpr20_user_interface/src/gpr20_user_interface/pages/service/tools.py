"""The page of SERVICE for the instruments: the height sensor, the VNA, the daily check."""

from __future__ import annotations

import math
from typing import Callable, Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QTextEdit

from gpr20_operator.robot.service_events import HeightTested
from gpr20_operator.robot.service_model import PARTS, DailyCheckState, ServiceState
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import INSTRUCTIONS, Part
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.widgets.widgets import new_button

UNKNOWN = "—"


class ServiceTools(TranslatedWidget):
    """One column per instrument: a button, and what came back."""

    def __init__(
        self,
        measure_height: Callable[[], None],
        test_analyzer: Callable[[], None],
        check_daily: Callable[[], None],
    ) -> None:
        super().__init__()
        self._state: Optional[ServiceState] = None
        self.measure = new_button(measure_height)
        self.test = new_button(test_analyzer)
        self.daily = new_button(check_daily)
        self.height_found, self.analyzer_found = _text_area(), _text_area()
        self.daily_found = _text_area()
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        for column, (button, text) in enumerate(
            (
                (self.measure, self.height_found),
                (self.test, self.analyzer_found),
                (self.daily, self.daily_found),
            )
        ):
            self._grid.addWidget(button, 0, column)
            self._grid.addWidget(text, 1, column)
        self._grid.setRowStretch(1, 1)
        self._grid.setColumnStretch(0, 2)
        self._grid.setColumnStretch(1, 3)
        self._grid.setColumnStretch(2, 3)
        self.restyle()
        self.retranslate()

    def show_state(self, state: ServiceState) -> None:
        """Show what came back."""
        if state == self._state:
            return
        self._state = state
        for button in (self.measure, self.test, self.daily):
            button.setEnabled(state.entered and not state.busy)
        self.height_found.setPlainText(self._height_text(state.height))
        self.analyzer_found.setPlainText(self._analyzer_text(state.analyzer))
        self.daily_found.setPlainText(self._daily_text(state.daily_check))
        self._write_daily(state.daily_check.part)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self._grid.setSpacing(look_of(self).px(2 * GAP_PX))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.measure.setText(self.tr("MEASURE HEIGHT"))
        self.test.setText(self.tr("TEST VNA"))
        self._write_daily(None)
        state, self._state = self._state, None
        if state is not None:
            self.show_state(state)

    def _write_daily(self, part: Optional[Part]) -> None:
        text = self.tr("DAILY CHECK")
        if part is not None:
            text = self.tr("MEASURE {number}/{total}").format(
                number=PARTS.index(part) + 1, total=len(PARTS)
            )
        self.daily.setText(text)

    def _daily_text(self, check: DailyCheckState) -> str:
        if check.measuring:
            return self.tr("Measuring")
        lines = []
        if check.answer is not None:
            message = check.answer.message
            lines.append(shown_text(message))
            if message.remedy is not None:
                lines.append(shown_text(message.remedy))
        if check.part is not None:
            lines.append(shown_text(INSTRUCTIONS[check.part]))
        return "\n".join(lines) or UNKNOWN

    def _height_text(self, height: Optional[HeightTested]) -> str:
        if height is None:
            return UNKNOWN
        lines = []
        if height.failure is None:
            lines.append(
                self.tr("Height {height_m:.3f} m ± {spread_m:.3f} m").format(
                    height_m=height.height_m, spread_m=height.spread_m
                )
            )
        if math.isfinite(height.voltage_v):
            lines.append(self.tr("Sensor {voltage_v:.3f} V").format(voltage_v=height.voltage_v))
        if height.failure is not None:
            lines.append(shown_text(height.failure))
        return "\n".join(lines)

    def _analyzer_text(self, test: Optional[AnalyzerTest]) -> str:
        if test is None:
            return UNKNOWN
        lines = []
        if test.identity:
            lines.append(self.tr("Connected to {address}").format(address=test.address))
            lines.append(test.identity)
        calibration = CalibrationStatus.named(test.calibration)
        if calibration is not None:
            state = shown_text(calibration.meaning)
            lines.append(self.tr("Calibration: {state}").format(state=state))
        if test.points:
            lines.append(
                self.tr("Sweep of {points} points: {duration_s:.3f} s, {level_db:.0f} dB").format(
                    points=test.points,
                    duration_s=test.sweep_duration_s,
                    level_db=test.level_db,
                )
            )
        if test.failure is not None:
            lines.append(self.tr("FAULT: {reason}").format(reason=shown_text(test.failure)))
            if test.failure.remedy is not None:
                lines.append(shown_text(test.failure.remedy))
        return "\n".join(lines)


def _text_area() -> QTextEdit:
    """Return a text that scrolls: a failure may be long."""
    area = QTextEdit(UNKNOWN)
    area.setReadOnly(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return area
