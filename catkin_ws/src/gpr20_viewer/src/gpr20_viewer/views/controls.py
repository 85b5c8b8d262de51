"""The settings of the viewer."""

from __future__ import annotations

import math
from typing import Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QHBoxLayout,
    QSlider,
    QWidget,
)

from gpr20_analysis.dataset import MM_PER_M
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_viewer.scene import Display

SLIDER_STEPS = 400
KEY_STEP = 0.1
DEEPEST_MM = (20.0, 5000.0)
RANGE_DB = (5.0, 120.0)
MOST_GAIN_DB_PER_NS = 20.0


class Controls(QWidget):
    """The settings; each change is one signal.

    Attributes:
        permittivity_changed: The analyst has set a permittivity.
        image_changed: A setting was changed that the image depends on.
        display_changed: A setting was changed that the image does not depend on.
    """

    permittivity_changed = pyqtSignal(float)
    image_changed = pyqtSignal()
    display_changed = pyqtSignal()

    def __init__(
        self,
        rotations_deg: Sequence[float],
        axes: Sequence[str],
        deepest_m: float,
        background: bool,
        range_db: float,
    ) -> None:
        super().__init__()
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, SLIDER_STEPS)
        self.permittivity_box = _box(MIN_PERMITTIVITY, MAX_PERMITTIVITY, 2, KEY_STEP)
        self.polarization = QComboBox()
        for turn_deg in rotations_deg:
            combined = "combination"
            self.polarization.addItem(combined if math.isnan(turn_deg) else f"{turn_deg:g}°")
        self.direction = QComboBox()
        for axis in axes:
            self.direction.addItem(f"along {axis}", axis)
        if len(axes) == 1:
            only = f"along {axes[0]}: a single line"
            self.direction.setItemText(0, only)
            self.direction.setEnabled(False)
        self.background = QCheckBox("subtract coupling and surface")
        self.background.setChecked(background)
        self.deepest = _box(*DEEPEST_MM, 0, 10.0, " mm")
        self.deepest.setValue(deepest_m * MM_PER_M)
        self.range = _box(*RANGE_DB, 0, 5.0, " dB")
        self.range.setValue(range_db)
        self.gain = _box(0.0, MOST_GAIN_DB_PER_NS, 1, 0.5, " dB/ns")
        self._lay_out()
        self.slider.valueChanged.connect(self._slid)
        self.permittivity_box.valueChanged.connect(self._typed)
        self.background.toggled.connect(lambda _on: self.image_changed.emit())
        self.deepest.valueChanged.connect(lambda _mm: self.image_changed.emit())
        for choice in (self.polarization, self.direction):
            choice.currentIndexChanged.connect(lambda _index: self.display_changed.emit())
        for number in (self.range, self.gain):
            number.valueChanged.connect(lambda _value: self.display_changed.emit())

    @property
    def permittivity(self) -> float:
        """The permittivity that is set."""
        return float(self.permittivity_box.value())

    @property
    def deepest_m(self) -> float:
        """Depth of the deepest layer [m]."""
        return float(self.deepest.value()) / MM_PER_M

    @property
    def display(self) -> Display:
        """How the image is drawn."""
        return Display(
            self.polarization.currentIndex(),
            str(self.direction.currentData()),
            float(self.range.value()),
            float(self.gain.value()),
        )

    def show_permittivity(self, permittivity: float) -> None:
        """Show a permittivity that the analyst has not set."""
        for widget in (self.slider, self.permittivity_box):
            widget.blockSignals(True)
        self.permittivity_box.setValue(permittivity)
        self.slider.setValue(_slider_steps(permittivity))
        for widget in (self.slider, self.permittivity_box):
            widget.blockSignals(False)

    def step_permittivity(self, steps: int) -> None:
        """Change the permittivity by steps of a key."""
        self.permittivity_box.stepBy(steps)

    def next_polarization(self) -> None:
        """Show the next polarization."""
        _next(self.polarization)

    def next_direction(self) -> None:
        """Show the other direction."""
        _next(self.direction)

    def _slid(self, steps: int) -> None:
        share = steps / SLIDER_STEPS
        ratio = MAX_PERMITTIVITY / MIN_PERMITTIVITY
        self.show_permittivity_of_slider(round(MIN_PERMITTIVITY * ratio**share, 2))

    def show_permittivity_of_slider(self, permittivity: float) -> None:
        """Show in the box what the slider has set."""
        self.permittivity_box.blockSignals(True)
        self.permittivity_box.setValue(permittivity)
        self.permittivity_box.blockSignals(False)
        self.permittivity_changed.emit(permittivity)

    def _typed(self, permittivity: float) -> None:
        self.slider.blockSignals(True)
        self.slider.setValue(_slider_steps(permittivity))
        self.slider.blockSignals(False)
        self.permittivity_changed.emit(permittivity)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(self.slider, 1)
        row.addWidget(self.permittivity_box)
        form = QFormLayout(self)
        form.setContentsMargins(4, 4, 4, 4)
        form.addRow("Permittivity", row)
        form.addRow("Polarization", self.polarization)
        form.addRow("Section", self.direction)
        form.addRow("Background", self.background)
        form.addRow("Deepest layer", self.deepest)
        form.addRow("Colour range", self.range)
        form.addRow("Display gain", self.gain)


def _box(
    lowest: float, highest: float, decimals: int, step: float, unit: str = ""
) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setDecimals(decimals)
    box.setRange(lowest, highest)
    box.setSingleStep(step)
    box.setSuffix(unit)
    # A number that is being typed is not yet the one that is meant.
    box.setKeyboardTracking(False)
    box.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
    return box


def _slider_steps(permittivity: float) -> int:
    ratio = MAX_PERMITTIVITY / MIN_PERMITTIVITY
    return round(SLIDER_STEPS * math.log(permittivity / MIN_PERMITTIVITY) / math.log(ratio))


def _next(choice: QComboBox) -> None:
    choice.setCurrentIndex((choice.currentIndex() + 1) % choice.count())
