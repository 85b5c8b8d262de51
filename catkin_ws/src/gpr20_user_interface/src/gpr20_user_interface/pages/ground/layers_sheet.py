"""What is drawn on GROUND, and how; nothing here changes the data."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, List, Tuple

import numpy as np
from PyQt5.QtCore import QSize, pyqtSignal
from PyQt5.QtGui import QPixmap
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.patterns import TILES, pattern_colours
from gpr20_operator.ground.sources import Axis, Layer
from gpr20_operator.ground.texts import STATE_NAMES
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.plot import image_of
from gpr20_user_interface.widgets.widgets import new_button

COLUMNS = 20
SWATCH_PX = 24


class LayersSheet(Overlay):
    """Keys that are labelled with what is shown now; the first row chooses the layer."""

    changed = pyqtSignal()

    def __init__(self, window: QWidget, model: GroundModel) -> None:
        super().__init__(window)
        self._model = model
        self.layers = {one: self._key(partial(model.change, layer=one)) for one in Layer}
        self.legend: Dict[StopState, Tuple[QLabel, QLabel]] = {
            one: (QLabel(), QLabel()) for one in STATE_NAMES
        }
        self.next_problem = self._key(model.choose_next_problem)
        self.along = self._key(model.turn)
        self.polarization = self._key(model.next_polarization)
        self.background = self._key(self._toggle_background)
        self.follow = self._key(lambda: model.follow(not model.follows))
        self.done = self._key(self.hide)
        self.next_problem.clicked.connect(self.hide)
        for key in self.layers.values():
            key.setCheckable(True)
        self._grid = QGridLayout(self)
        self._lay_out()
        self.retranslate()

    def open(self) -> None:
        """Show what is chosen now, over the page."""
        self._show()
        super().open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.next_problem.setText(self.tr("Next\ngap"))
        self.done.setText(self.tr("CLOSE"))
        self._show()

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        gap, size = look.px(GAP_PX), look.px(SWATCH_PX)
        self._grid.setSpacing(gap)
        self._grid.setContentsMargins(gap, gap, gap, gap)
        for state, (swatch, _count) in self.legend.items():
            image = image_of(np.tile(TILES[state], (2, 2)), pattern_colours(look.theme))
            swatch.setPixmap(QPixmap.fromImage(image.copy(0, 0, size, size)))
            swatch.setFixedSize(QSize(size, size))

    def _show(self) -> None:
        model, settings, grid = self._model, self._model.settings, self._model.survey.radar.grid
        names = {
            Layer.COVERAGE: self.tr("Coverage"),
            Layer.ECHOES: self.tr("Echoes"),
            Layer.FOCUSED: self.tr("Focused\nimage"),
            Layer.HIDING: self.tr("Hiding\nplaces"),
        }
        for layer, key in self.layers.items():
            key.setText(names[layer])
            key.setChecked(layer is settings.layer)
        # Nobody asked yet where a mine could hide: that takes minutes.
        self.layers[Layer.HIDING].setEnabled(model.additions.hiding is not None)
        counts = model.survey.map.counts()
        for state, (_swatch, label) in self.legend.items():
            number = "—" if counts is None else str(counts[state])
            label.setText(f"{shown_text(STATE_NAMES[state])}: {number}")
        self.next_problem.setEnabled(model.survey.map.next_problem(None) is not None)
        rotation_deg = 0.0 if grid is None else grid.rotations_deg[settings.polarization]
        antenna = Message("Antenna\n{rotation:g}°", rotation=rotation_deg)
        self.polarization.setText(shown_text(antenna))
        along_x, along_y = self.tr("Section\nalong X"), self.tr("Section\nalong Y")
        self.along.setText(along_x if settings.along is Axis.X_MM else along_y)
        removed, included = self.tr("Background\nremoved"), self.tr("Background\nincluded")
        self.background.setText(removed if settings.remove_background else included)
        follows, stays = self.tr("Crosshair\nlast trace"), self.tr("Crosshair\nstays")
        self.follow.setText(follows if model.follows else stays)

    def _key(self, act: Callable[[], None]) -> QPushButton:
        key = new_button(lambda: self._do(act))
        key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        key.setObjectName("ground_choice")
        return key

    def _do(self, act: Callable[[], None]) -> None:
        act()
        self._show()
        self.changed.emit()

    def _toggle_background(self) -> None:
        self._model.change(remove_background=not self._model.settings.remove_background)

    def _lay_out(self) -> None:
        legend = QWidget()
        line = QHBoxLayout(legend)
        line.setContentsMargins(0, 0, 0, 0)
        for swatch, count in self.legend.values():
            line.addWidget(swatch)
            line.addWidget(count, 1)
        rows: List[List[QWidget]] = [
            list(self.layers.values()),
            [legend, self.next_problem],
            [self.along, self.polarization, self.background, self.follow, self.done],
        ]
        spans = {1: [16, 4]}
        for row, widgets in enumerate(rows):
            # CLOSE ends below the middle, where other sheets have what is held.
            self._grid.setRowStretch(row, 2 if widgets[-1] is self.done else 3)
            wide = spans.get(row, [COLUMNS // len(widgets)] * len(widgets))
            for number, widget in enumerate(widgets):
                self._grid.addWidget(widget, row, sum(wide[:number]), 1, wide[number])
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
