"""How RADAR shows the echoes; nothing here changes the data."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, List, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QPushButton, QSizePolicy, QWidget

from gpr20_operator.ground.records import Colours
from gpr20_survey.radar.soils import Soils, soil_of
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground.radar_model import RadarPresenter
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import Stepper, new_button

# By halves where soils lie close together in depth, in larger steps above.
PERMITTIVITIES = [
    1.0,
    *(half / 2.0 for half in range(4, 20)),
    *(float(one) for one in range(10, 41)),
]
GAINS_DB_PER_NS = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
COLUMNS = 20


class RadarSheet(Overlay):
    """Buttons that are labelled with what is shown now.

    Args:
        window: The window to cover.
        presenter: What is chosen.
    """

    changed = pyqtSignal()
    fit_wanted = pyqtSignal()

    def __init__(self, window: QWidget, presenter: RadarPresenter) -> None:
        super().__init__(window)
        self._presenter = presenter
        self._own = 9.0
        self.soils: Dict[Optional[Soils], QPushButton] = {
            soil: self._key(partial(self._on_soil, soil)) for soil in (*Soils, None)
        }
        self.permittivity = Stepper(PERMITTIVITIES, presenter.settings.permittivity)
        self.fit = self._key(self._on_fit)
        self.gain = Stepper(GAINS_DB_PER_NS, presenter.settings.gain_db_per_ns)
        self.colours: Dict[Colours, QPushButton] = {
            colours: self._key(partial(self._change, colours=colours)) for colours in Colours
        }
        self.polarization = self._key(self._on_polarization)
        self.axis = self._key(lambda: self._toggle("in_depth"))
        self.scale = self._key(lambda: self._toggle("in_db"))
        self.background = self._key(lambda: self._toggle("remove_background"))
        self.follow = self._key(self._on_follow)
        self.done = self._key(self.hide)
        for button in (*self.soils.values(), *self.colours.values()):
            button.setCheckable(True)
        self.permittivity.changed.connect(lambda value: self._change(permittivity=value))
        self.gain.changed.connect(lambda value: self._change(gain_db_per_ns=value))
        self._grid = QGridLayout(self)
        self._lay_out()
        self.retranslate()

    def open(self) -> None:
        """Show what is chosen now, over the tabs."""
        self._show()
        super().open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.permittivity.set_texts(self.tr("Permittivity"), "{value:g}")
        self.gain.set_texts(self.tr("Gain"), self.tr("{value:g} dB/ns"))
        self.fit.setText(self.tr("Fit a\nhyperbola"))
        self.done.setText(self.tr("CLOSE"))
        self._show()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap = look_of(self).px(GAP_PX)
        self._grid.setSpacing(gap)
        self._grid.setContentsMargins(gap, gap, gap, gap)

    def _show(self) -> None:
        settings, grid = self._presenter.settings, self._presenter.model.grid
        chosen = soil_of(settings.permittivity)
        if chosen is None:
            self._own = settings.permittivity
        for soil, button in self.soils.items():
            name = self.tr("Your own") if soil is None else shown_text(soil.value.name)
            value = self._own if soil is None else soil.value.permittivity
            words = name.replace(" ", "\n")
            button.setText(f"{words}\n{value:g}")
            button.setChecked(soil is chosen)
        self.permittivity.set_value(settings.permittivity)
        self.fit.setEnabled(self._presenter.can_fit)
        names = {
            Colours.ENVELOPE: self.tr("Envelope"),
            Colours.GREY: self.tr("Grey"),
            Colours.RED_WHITE_BLUE: self.tr("Red-white-\nblue"),
        }
        for colours, button in self.colours.items():
            button.setText(names[colours])
            button.setChecked(colours is settings.colours)
        rotation_deg = 0.0 if grid is None else grid.rotations_deg[settings.polarization]
        self.polarization.setText(self.tr("Antenna\n{rotation:g}°").format(rotation=rotation_deg))
        self.axis.setText(self.tr("Axis\ndepth") if settings.in_depth else self.tr("Axis\ntime"))
        self.scale.setText(self.tr("Scale\ndB") if settings.in_db else self.tr("Scale\nlinear"))
        removed = self.tr("Background\nremoved")
        included = self.tr("Background\nincluded")
        self.background.setText(removed if settings.remove_background else included)
        follows = self.tr("Crosshair\nlast trace")
        stays = self.tr("Crosshair\nstays")
        self.follow.setText(follows if self._presenter.follows else stays)

    def _key(self, act: Callable[[], None]) -> QPushButton:
        button = new_button(act)
        button.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        return button

    def _on_soil(self, soil: Optional[Soils]) -> None:
        self._change(permittivity=self._own if soil is None else soil.value.permittivity)

    def _on_fit(self) -> None:
        self.hide()
        self.fit_wanted.emit()

    def _on_polarization(self) -> None:
        self._presenter.next_polarization()
        self._announce()

    def _on_follow(self) -> None:
        self._presenter.follow(not self._presenter.follows)
        self._announce()

    def _toggle(self, name: str) -> None:
        self._change(**{name: not getattr(self._presenter.settings, name)})

    def _change(self, **changes: object) -> None:
        self._presenter.change(**changes)
        self._announce()

    def _announce(self) -> None:
        self._show()
        self.changed.emit()

    def _lay_out(self) -> None:
        rows: List[List[QWidget]] = [
            list(self.soils.values()),
            [self.permittivity, self.fit, self.gain],
            [*self.colours.values(), self.scale],
            [self.polarization, self.axis, self.background, self.follow, self.done],
        ]
        for row, widgets in enumerate(rows):
            # Three do not divide the columns: the middle one is narrower.
            spans = [8, 4, 8] if len(widgets) == 3 else [COLUMNS // len(widgets)] * len(widgets)
            for number, widget in enumerate(widgets):
                first = sum(spans[:number])
                self._grid.addWidget(widget, row, first, 1, spans[number])
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
