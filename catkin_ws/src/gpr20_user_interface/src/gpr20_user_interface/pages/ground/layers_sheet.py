"""What is drawn on GROUND, and how; nothing here changes the data."""

from __future__ import annotations

from functools import partial
from typing import Callable, Dict, Tuple

import numpy as np
from PyQt5.QtCore import QSize, pyqtSignal
from PyQt5.QtGui import QPixmap
from PyQt5.QtWidgets import QLabel, QPushButton, QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.patterns import TILES, pattern_colours
from gpr20_operator.ground.sources import Axis, Layer
from gpr20_operator.ground.texts import STATE_NAMES
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.plot import image_of
from gpr20_user_interface.widgets.widgets import column, new_button, row, say

SWATCH_PX = 24
NAMES = {
    Layer.COVERAGE: Message("Coverage"),
    Layer.ECHOES: Message("Echoes"),
    Layer.FOCUSED: Message("Focused\nimage"),
    Layer.HIDING: Message("Hiding\nplaces"),
}


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
        say(self.next_problem, Message("Next\ngap"))
        say(self.done, Message("CLOSE"))
        self.next_problem.clicked.connect(self.hide)
        for layer, key in self.layers.items():
            key.setCheckable(True)
            say(key, NAMES[layer])
        self._lay_out()
        self._show()

    def open(self) -> None:
        """Show what is chosen now, over the page."""
        self._show()
        super().open()

    def restyle(self) -> None:
        """Paint the swatches in the colours of the look."""
        look = look_of(self)
        size = look.px(SWATCH_PX)
        for state, (swatch, _count) in self.legend.items():
            image = image_of(np.tile(TILES[state], (2, 2)), pattern_colours(look.theme))
            swatch.setPixmap(QPixmap.fromImage(image.copy(0, 0, size, size)))
            swatch.setFixedSize(QSize(size, size))

    def _show(self) -> None:
        model, settings, grid = self._model, self._model.settings, self._model.survey.radar.grid
        for layer, key in self.layers.items():
            key.setChecked(layer is settings.layer)
        # Nobody asked yet where a mine could hide: that takes minutes.
        self.layers[Layer.HIDING].setEnabled(model.additions.hiding is not None)
        counts = model.survey.map.counts()
        for state, (_swatch, label) in self.legend.items():
            number = "—" if counts is None else str(counts[state])
            say(label, Message("{name}: {number}", name=STATE_NAMES[state], number=number))
        self.next_problem.setEnabled(model.survey.map.next_problem(None) is not None)
        rotation_deg = 0.0 if grid is None else grid.rotations_deg[settings.polarization]
        say(self.polarization, Message("Antenna\n{rotation:g}°", rotation=rotation_deg))
        along_x, along_y = Message("Section\nalong X"), Message("Section\nalong Y")
        say(self.along, along_x if settings.along is Axis.X_MM else along_y)
        removed, included = Message("Background\nremoved"), Message("Background\nincluded")
        say(self.background, removed if settings.remove_background else included)
        follows, stays = Message("Crosshair\nlast trace"), Message("Crosshair\nstays")
        say(self.follow, follows if model.follows else stays)

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
        swatches = (part for one, name in self.legend.values() for part in (one, (name, 1)))
        keys = self.along, self.polarization, self.background, self.follow, self.done
        # CLOSE ends below the middle, where other sheets have what is held.
        rows = (
            (row(*((one, 1) for one in self.layers.values())), 3),
            (row((row(*swatches), 4), (self.next_problem, 1)), 3),
            (row(*((one, 1) for one in keys)), 2),
        )
        self.setLayout(column(*rows, margin=GAP_PX))
