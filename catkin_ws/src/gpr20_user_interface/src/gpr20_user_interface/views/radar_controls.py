"""How the echoes are shown; nothing here changes the data."""

from __future__ import annotations

import dataclasses
from typing import Sequence, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QWidget

from gpr20_user_interface.mid.radar_pictures import RadarSettings
from gpr20_user_interface.views.translation import TranslatedWidget
from gpr20_user_interface.views.widgets import new_button

PERMITTIVITIES = (1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0)
GAINS_DB_PER_NS = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)


class Stepper(QWidget):
    """Chooses one of a few numbers."""

    changed = pyqtSignal(float)

    def __init__(self, values: Sequence[float], start: float) -> None:
        super().__init__()
        self._values = list(values)
        self._place = self._values.index(start)
        self._title, self._pattern = "", "{value:g}"
        self.less = new_button(lambda: self._step(-1), "\N{MINUS SIGN}")
        self.more = new_button(lambda: self._step(+1), "+")
        self._label = QLabel()
        self._label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.less)
        layout.addWidget(self._label, 1)
        layout.addWidget(self.more)
        self._show()

    @property
    def value(self) -> float:
        """The number that is chosen."""
        return self._values[self._place]

    @property
    def text(self) -> str:
        """What is written between the buttons."""
        return self._label.text()

    def set_texts(self, title: str, pattern: str) -> None:
        """Set title and pattern of the number; the pattern contains {value}."""
        self._title, self._pattern = title, pattern
        self._show()

    def _step(self, direction: int) -> None:
        place = min(max(self._place + direction, 0), len(self._values) - 1)
        if place != self._place:
            self._place = place
            self._show()
            self.changed.emit(self.value)

    def _show(self) -> None:
        self._label.setText(f"{self._title}\n{self._pattern.format(value=self.value)}")
        self.less.setEnabled(self._place > 0)
        self.more.setEnabled(self._place < len(self._values) - 1)


class RadarControls(TranslatedWidget):
    """A row of buttons, each labelled with what is shown now.

    Attributes:
        settings: What is chosen.
    """

    # Carries the RadarSettings.
    changed = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self.settings = RadarSettings()
        self._rotations_deg: Tuple[float, ...] = (0.0,)
        self.polarization = new_button(self._next_polarization)
        self.axis = new_button(lambda: self._change(in_depth=not self.settings.in_depth))
        self.scale = new_button(lambda: self._change(in_db=not self.settings.in_db))
        self.background = new_button(
            lambda: self._change(remove_background=not self.settings.remove_background)
        )
        self.permittivity = Stepper(PERMITTIVITIES, self.settings.permittivity)
        self.gain = Stepper(GAINS_DB_PER_NS, self.settings.gain_db_per_ns)
        self.permittivity.changed.connect(lambda value: self._change(permittivity=value))
        self.gain.changed.connect(lambda value: self._change(gain_db_per_ns=value))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        for button in (self.polarization, self.axis, self.scale, self.background):
            layout.addWidget(button)
        layout.addWidget(self.permittivity, 1)
        layout.addWidget(self.gain, 1)
        self.retranslate()

    def set_rotations(self, rotations_deg: Tuple[float, ...]) -> None:
        """Set the antenna rotations to choose from."""
        if rotations_deg != self._rotations_deg:
            self._rotations_deg = rotations_deg
            number = min(self.settings.polarization, len(rotations_deg) - 1)
            self._change(polarization=number)

    def set_depth(self, depth_m: float) -> None:
        """Take the depth of the slice [m]."""
        if depth_m != self.settings.depth_m:
            self._change(depth_m=depth_m)

    def _next_polarization(self) -> None:
        self._change(polarization=(self.settings.polarization + 1) % len(self._rotations_deg))

    def _change(self, **changes: object) -> None:
        self.settings = dataclasses.replace(self.settings, **changes)  # type: ignore[arg-type]
        self._show()
        self.changed.emit(self.settings)

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self.permittivity.set_texts(self.tr("Permittivity"), "{value:g}")
        self.gain.set_texts(self.tr("Gain"), self.tr("{value:g} dB/ns"))
        self._show()

    def _show(self) -> None:
        settings = self.settings
        rotation_deg = self._rotations_deg[settings.polarization]
        self.polarization.setText(self.tr("Antenna\n{rotation:g}°").format(rotation=rotation_deg))
        self.axis.setText(self.tr("Axis\ndepth") if settings.in_depth else self.tr("Axis\ntime"))
        self.scale.setText(self.tr("Scale\ndB") if settings.in_db else self.tr("Scale\nlinear"))
        removed = self.tr("Background\nremoved")
        included = self.tr("Background\nincluded")
        self.background.setText(removed if settings.remove_background else included)
