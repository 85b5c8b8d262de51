"""What is drawn on GROUND, and how; nothing here changes the data."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, List, Optional

from PyQt5.QtCore import QSize, pyqtSignal
from PyQt5.QtGui import QPixmap
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.cells import Cell
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.model import GroundModel, Layer
from gpr20_operator.ground.records import Axis, Colours
from gpr20_operator.ground.texts import STATE_NAMES
from gpr20_survey.radar.soils import Soils, soil_of
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_number, shown_text
from gpr20_user_interface.widgets.cells import pattern_image
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import Stepper, new_button

# By halves where soils lie close together in depth, in larger steps above.
PERMITTIVITIES = [
    1.0,
    *(half / 2.0 for half in range(4, 20)),
    *(float(one) for one in range(10, 41)),
]
GAINS_DB_PER_NS = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
COLUMNS = 60
SWATCH_PX = 24


class LayersSheet(Overlay):
    """Keys that are labelled with what is shown now; the first row switches the layers."""

    changed = pyqtSignal()

    def __init__(self, window: QWidget, model: GroundModel) -> None:
        super().__init__(window)
        self._model = model
        self._own = 9.0
        self.layers = {one: self._key(partial(model.switch, one)) for one in Layer}
        self.counts: Dict[StopState, QLabel] = {one: QLabel() for one in STATE_NAMES}
        self.swatches: Dict[StopState, QLabel] = {one: QLabel() for one in STATE_NAMES}
        self.next_problem = self._key(model.choose_next_problem)
        # The page opens what these two are for.
        self.markers, self.fit = self._key(self.hide), self._key(self.hide)
        self.soils: Dict[Optional[Soils], QPushButton] = {
            soil: self._key(partial(self._choose_soil, soil)) for soil in (*Soils, None)
        }
        self.permittivity = Stepper(PERMITTIVITIES, model.settings.permittivity)
        self.gain = Stepper(GAINS_DB_PER_NS, model.settings.gain_db_per_ns)
        self.colours: Dict[Colours, QPushButton] = {
            colours: self._key(partial(model.change, colours=colours)) for colours in Colours
        }
        self.scale = self._key(partial(self._toggle, "in_db"))
        self.along = self._key(self._turn)
        self.polarization = self._key(model.next_polarization)
        self.axis = self._key(partial(self._toggle, "in_depth"))
        self.background = self._key(partial(self._toggle, "remove_background"))
        self.follow = self._key(lambda: model.follow(not model.follows))
        self.done = self._key(self.hide)
        self.next_problem.clicked.connect(self.hide)
        for key in (*self.layers.values(), *self.soils.values(), *self.colours.values()):
            key.setCheckable(True)
        self.permittivity.changed.connect(
            lambda value: self._do(partial(model.change, permittivity=value))
        )
        self.gain.changed.connect(
            lambda value: self._do(partial(model.change, gain_db_per_ns=value))
        )
        self._grid = QGridLayout(self)
        self._lay_out()
        self.retranslate()

    def open(self) -> None:
        """Show what is chosen now, over the page."""
        self._show()
        super().open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.permittivity.set_texts(self.tr("Permittivity"))
        self.gain.set_texts(self.tr("Gain"), " dB/ns")
        self.fit.setText(self.tr("Fit a\nhyperbola"))
        self.next_problem.setText(self.tr("Next\ngap"))
        self.done.setText(self.tr("CLOSE"))
        self._show()

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        gap, size = look.px(GAP_PX), look.px(SWATCH_PX)
        self._grid.setSpacing(gap)
        self._grid.setContentsMargins(gap, gap, gap, gap)
        for state, swatch in self.swatches.items():
            swatch.setPixmap(QPixmap.fromImage(pattern_image(Cell(state), size, look)))
            swatch.setFixedSize(QSize(size, size))

    def _show(self) -> None:
        self._show_layers()
        model, settings, grid = self._model, self._model.settings, self._model.survey.radar.grid
        chosen = soil_of(settings.permittivity)
        if chosen is None:
            self._own = settings.permittivity
        for soil, key in self.soils.items():
            name = self.tr("Your own") if soil is None else shown_text(soil.value.name)
            key.setText(f"{name}\n{shown_number(self._permittivity_of(soil))}")
            key.setChecked(soil is chosen)
        self.permittivity.set_value(settings.permittivity)
        self.gain.set_value(settings.gain_db_per_ns)
        depth_ns = model.second_of(0.0, Axis.DELAY_NS)
        self.fit.setEnabled(model.place is not None and depth_ns is not None)
        names = {
            Colours.ENVELOPE: self.tr("Strength"),
            Colours.GREY: self.tr("Wave,\ngrey"),
            Colours.RED_WHITE_BLUE: self.tr("Wave,\nred-blue"),
        }
        for colours, key in self.colours.items():
            key.setText(names[colours])
            key.setChecked(colours is settings.colours)
        rotation_deg = 0.0 if grid is None else grid.rotations_deg[settings.polarization]
        antenna = Message("Antenna\n{rotation:g}°", rotation=rotation_deg)
        self.polarization.setText(shown_text(antenna))
        along_x, along_y = self.tr("Section\nalong X"), self.tr("Section\nalong Y")
        self.along.setText(along_x if settings.along is Axis.X_MM else along_y)
        self.axis.setText(self.tr("Axis\ndepth") if settings.in_depth else self.tr("Axis\ntime"))
        self.scale.setText(self.tr("Scale\ndB") if settings.in_db else self.tr("Scale\nlinear"))
        removed, included = self.tr("Background\nremoved"), self.tr("Background\nincluded")
        self.background.setText(removed if settings.remove_background else included)
        follows, stays = self.tr("Crosshair\nlast trace"), self.tr("Crosshair\nstays")
        self.follow.setText(follows if model.follows else stays)

    def _show_layers(self) -> None:
        model, additions = self._model, self._model.additions
        names = {
            Layer.COVERAGE: self.tr("Coverage"),
            Layer.ECHOES: self.tr("Echoes"),
            Layer.FOCUSED: self.tr("Focused\nimage"),
            Layer.CANDIDATES: self.tr("Candidates"),
            Layer.MARKERS: self.tr("Markers"),
            Layer.HIDING: self.tr("Hiding\nplaces"),
        }
        for layer, key in self.layers.items():
            key.setText(f"✓ {names[layer]}" if layer in model.layers else names[layer])
            key.setChecked(layer in model.layers)
        # Nobody asked yet where a mine could hide: that takes minutes.
        self.layers[Layer.HIDING].setEnabled(additions.hiding is not None)
        counts = model.survey.map.counts()
        for state, label in self.counts.items():
            number = "—" if counts is None else str(counts[state])
            label.setText(f"{shown_text(STATE_NAMES[state])}: {number}")
        self.next_problem.setEnabled(model.survey.map.next_problem(None) is not None)
        title = self.tr("List of\nmarkers")
        self.markers.setText(f"{title}: {len(additions.markers)}")
        self.markers.setEnabled(bool(additions.markers))

    def _key(self, act: Callable[[], None]) -> QPushButton:
        key = new_button(lambda: self._do(act))
        key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        key.setObjectName("ground_choice")
        return key

    def _do(self, act: Callable[[], None]) -> None:
        act()
        self._show()
        self.changed.emit()

    def _permittivity_of(self, soil: Optional[Soils]) -> float:
        return self._own if soil is None else soil.value.permittivity

    def _choose_soil(self, soil: Optional[Soils]) -> None:
        self._model.change(permittivity=self._permittivity_of(soil))

    def _turn(self) -> None:
        along_x = self._model.settings.along is Axis.X_MM
        self._model.change(along=Axis.Y_MM if along_x else Axis.X_MM)

    def _toggle(self, name: str) -> None:
        self._model.change(**{name: not getattr(self._model.settings, name)})

    def _lay_out(self) -> None:
        legend = QWidget()
        line = QHBoxLayout(legend)
        line.setContentsMargins(0, 0, 0, 0)
        for state in STATE_NAMES:
            line.addWidget(self.swatches[state])
            line.addWidget(self.counts[state], 1)
        rows: List[List[QWidget]] = [
            list(self.layers.values()),
            [legend, self.next_problem, self.markers],
            list(self.soils.values()),
            [self.permittivity, self.fit, self.gain],
            [*self.colours.values(), self.scale, self.along],
            [self.polarization, self.axis, self.background, self.follow, self.done],
        ]
        spans = {1: [40, 10, 10], 3: [24, 12, 24]}
        for row, widgets in enumerate(rows):
            wide = spans.get(row, [COLUMNS // len(widgets)] * len(widgets))
            for number, widget in enumerate(widgets):
                self._grid.addWidget(widget, row, sum(wide[:number]), 1, wide[number])
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
