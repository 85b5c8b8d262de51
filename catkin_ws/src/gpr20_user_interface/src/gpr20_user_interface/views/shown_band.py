"""The thick band above a picture that is not of the survey that runs."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout

from gpr20_user_interface.mid.shown_band import ShownBand
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.look import GAP_PX
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import new_button, set_look


class ShownBandView(TranslatedWidget):
    """Names the survey, with the way back to the live one; hidden while the live one is shown."""

    back_touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("shown_band")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._band: Optional[ShownBand] = None
        self.text = ElidedLabel()
        self.back = new_button(self.back_touched.emit)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(GAP_PX, 2, 2, 2)
        layout.addWidget(self.text, 1)
        layout.addWidget(self.back)
        self.hide()
        self.retranslate()

    def show_band(self, band: Optional[ShownBand]) -> None:
        """Show a band; None: the live survey is shown."""
        if band != self._band:
            self._band = band
            self.setVisible(band is not None)
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.back.setText(self.tr("Back to live"))
        if self._band is not None:
            self.text.show_text(shown_text(self._band.text))
            self.back.setVisible(self._band.can_return)
            set_look(self, "replay", self._band.replay)
