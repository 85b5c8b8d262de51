"""The settings of the viewer: a slider for the permittivity, and a tree of the others."""

from __future__ import annotations

import math
from typing import Any, Sequence

import pyqtgraph
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QSlider, QVBoxLayout, QWidget
from pyqtgraph.parametertree import Parameter, ParameterTree

from gpr20_survey.radar import MAX_PERMITTIVITY, MIN_PERMITTIVITY

SLIDER_STEPS = 400
KEY_STEP = 0.1
BACKGROUND = "subtract coupling and surface"
HEIGHT_PX = 120


class Settings(QWidget):
    """The settings; each change is one signal.

    Attributes:
        permittivity_changed: The analyst has set a permittivity.
        background_changed: Whether the background is subtracted was changed.
        display_changed: A setting was changed that the image does not depend on.
        tree: The settings by name.
    """

    permittivity_changed = pyqtSignal(float)
    background_changed = pyqtSignal(bool)
    display_changed = pyqtSignal()

    def __init__(
        self,
        rotations_deg: Sequence[float],
        axes: Sequence[str],
        background: bool,
    ) -> None:
        super().__init__()
        turns = {f"{one:g}°": number for number, one in enumerate(rotations_deg)}
        self.tree = Parameter.create(
            name="settings",
            type="group",
            children=[
                {"type": "float", "name": "permittivity", "value": MIN_PERMITTIVITY,
                 "step": KEY_STEP, "decimals": 4,
                 "limits": (MIN_PERMITTIVITY, MAX_PERMITTIVITY)},
                {"type": "list", "name": "polarization", "limits": turns},
                {"type": "list", "name": "section", "limits": {f"along {one}": one for one in axes},
                 "enabled": len(axes) > 1},
                {"type": "bool", "name": BACKGROUND, "value": background},
            ],
        )  # fmt: skip
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.slider.setRange(0, SLIDER_STEPS)
        self.slider.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        shown = ParameterTree(showHeader=False)
        shown.setParameters(self.tree, showTop=False)
        shown.setFixedHeight(HEIGHT_PX)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.slider)
        layout.addWidget(shown)
        self.slider.valueChanged.connect(self._slid)
        self.tree.child("permittivity").sigValueChanged.connect(self._set)
        self.tree.child(BACKGROUND).sigValueChanged.connect(
            lambda _parameter, value: self.background_changed.emit(value)
        )
        for name in ("polarization", "section"):
            self.tree.child(name).sigValueChanged.connect(lambda *_: self.display_changed.emit())

    @property
    def permittivity(self) -> float:
        """The permittivity that is set."""
        return float(self.tree["permittivity"])

    @property
    def background(self) -> bool:
        """Whether the background is subtracted."""
        return bool(self.tree[BACKGROUND])

    @property
    def turn(self) -> int:
        """Index of the polarization."""
        return int(self.tree["polarization"])

    @property
    def along(self) -> str:
        """Direction of B-scan and section, "x" or "y"."""
        return str(self.tree["section"])

    def show_permittivity(self, permittivity: float) -> None:
        """Show a permittivity that the analyst has not set."""
        parameter = self.tree.child("permittivity")
        with pyqtgraph.SignalBlock(parameter.sigValueChanged, self._set):
            parameter.setValue(permittivity)
        self._show_on_slider(permittivity)

    def step_permittivity(self, steps: int) -> None:
        """Change the permittivity by steps of a key."""
        changed = round(self.permittivity + steps * KEY_STEP, 4)
        self.tree["permittivity"] = min(max(changed, MIN_PERMITTIVITY), MAX_PERMITTIVITY)

    def switch_background(self) -> None:
        """Subtract the background, or no longer."""
        self.tree.child(BACKGROUND).setValue(not self.background)

    def next(self, name: str) -> None:
        """Choose the next value of polarization or section."""
        parameter = self.tree.child(name)
        values = list(parameter.opts["limits"].values())
        parameter.setValue(values[(values.index(parameter.value()) + 1) % len(values)])

    def _slid(self, steps: int) -> None:
        ratio = MAX_PERMITTIVITY / MIN_PERMITTIVITY
        self.tree["permittivity"] = round(MIN_PERMITTIVITY * ratio ** (steps / SLIDER_STEPS), 2)

    def _set(self, _parameter: Any, permittivity: float) -> None:
        self._show_on_slider(permittivity)
        self.permittivity_changed.emit(permittivity)

    def _show_on_slider(self, permittivity: float) -> None:
        ratio = math.log(MAX_PERMITTIVITY / MIN_PERMITTIVITY)
        share = math.log(permittivity / MIN_PERMITTIVITY) / ratio
        self.slider.blockSignals(True)
        self.slider.setValue(round(SLIDER_STEPS * share))
        self.slider.blockSignals(False)
