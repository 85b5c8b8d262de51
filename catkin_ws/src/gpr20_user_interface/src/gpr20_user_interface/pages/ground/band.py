"""A tab that shows a survey, with the band that says which one if it is not the live one."""

from __future__ import annotations

from typing import Generic, Optional, TypeVar

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from gpr20_operator.ground.traces import ShownBand
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.widgets.labels import ElidedLabel
from gpr20_user_interface.widgets.widgets import new_button, set_look


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


View = TypeVar("View", bound=QWidget)


class BandPage(QWidget, Generic[View]):
    """A view below a ShownBandView.

    Attributes:
        view: What the tab shows.
        band: Hidden while that is the live survey.
    """

    def __init__(self, view: View) -> None:
        super().__init__()
        self.view = view
        self.band = ShownBandView()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.band)
        layout.addWidget(view, 1)
