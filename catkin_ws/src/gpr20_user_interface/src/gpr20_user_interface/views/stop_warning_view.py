"""Over everything below the top bar: a STOP is not confirmed, switch off the motors' power."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QVBoxLayout, QWidget

from gpr20_user_interface.mid.stop_confirmation import StopWarning
from gpr20_user_interface.views.hold_button import HoldButton
from gpr20_user_interface.views.lines_label import LinesLabel
from gpr20_user_interface.views.look import GAP_PX, look_of
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.translation import shown_text


class StopWarningView(Overlay):
    """Stays until the stop is confirmed, or the operator closes it by a hold."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("stop_warning")
        self._warning: Optional[StopWarning] = None
        self.title = QLabel()
        self.title.setObjectName("motors_off")
        self.title.setWordWrap(True)
        self.title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.text = LinesLabel()
        self.close_button = HoldButton()
        self._layout = QVBoxLayout(self)
        self._layout.addWidget(self.title, 3)
        self._layout.addWidget(self.text, 1)
        self._layout.addWidget(self.close_button)
        self.retranslate()

    def show_warning(self, warning: Optional[StopWarning]) -> None:
        """Show a warning over everything; None: there is none."""
        if warning is None:
            self.hide()
            return
        if warning != self._warning:
            self._warning = warning
            self.retranslate()
        if not self.isVisible():
            self.open()
        # Another sheet may have opened since.
        self.raise_()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("Hold to close"))
        if self._warning is not None:
            self.title.setText(shown_text(self._warning.title))
            self.text.show_text(shown_text(self._warning.text))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        margin_px = 3 * look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(margin_px, margin_px, margin_px, margin_px)
