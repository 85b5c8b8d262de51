"""The legend of the colours."""

from __future__ import annotations

import numpy as np
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QImage, QPixmap
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QWidget

from gpr20_viewer.views.colours import LEVELS, QUIET, level_colours

BAR_PX = (90, 12)


class ColourScale(QWidget):
    """What the colours mean.

    Attributes:
        text: The levels of the ends.
    """

    def __init__(self) -> None:
        super().__init__()
        colours = np.ascontiguousarray(level_colours()[:LEVELS])
        picture = QImage(colours.tobytes(), LEVELS, 1, 3 * LEVELS, QImage.Format.Format_RGB888)
        bar = QLabel()
        bar.setPixmap(QPixmap.fromImage(picture.copy()).scaled(*BAR_PX))
        self.text = QLabel()
        self.text.setStyleSheet(QUIET)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(4, 0, 4, 0)
        layout.addWidget(bar, 0, Qt.AlignmentFlag.AlignLeft)
        layout.addWidget(self.text, 1)

    def show_range(self, range_db: float) -> None:
        """Show the range of the colours [dB]."""
        self.text.setText(f"{-range_db:g} to 0 dB; grey: not measured")
