"""The band over the tabs of a locked screen: it says so, and unlocks it."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QWidget

from gpr20_user_interface.views.hold_button import HoldButton
from gpr20_user_interface.views.look import GAP_PX, TAB_PX, TOP_BAR_PX, look_of
from gpr20_user_interface.views.translation import TranslatedWidget
from gpr20_user_interface.views.widgets import set_look

# That of the tabs, and the line below them.
BAND_PX = TAB_PX + 2
FLASH_MS = 600


class LockBand(TranslatedWidget):
    """Covers the bar of the tabs while the screen is locked; hidden at first."""

    unlocked = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("lock_band")
        self.unlock = HoldButton()
        self.unlock.held.connect(self.unlocked)
        self.text = QLabel()
        self.text.setObjectName("locked")
        self._flash = QTimer(self)
        self._flash.setSingleShot(True)
        self._flash.setInterval(FLASH_MS)
        self._flash.timeout.connect(lambda: set_look(self.text, "flash", False))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(GAP_PX)
        layout.addWidget(self.unlock)
        layout.addWidget(self.text, 1)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()
        window.installEventFilter(self)
        self.retranslate()

    def cover(self) -> None:
        """Lie over the bar of the tabs, and over everything else that is there."""
        look, window = look_of(self), self.parentWidget()
        self.setGeometry(0, look.px(TOP_BAR_PX), window.width(), look.px(BAND_PX))
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() == QEvent.Type.Resize and self.isVisible():
            self.cover()
        return super().eventFilter(watched, event)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        if self.isVisible():
            self.cover()

    def flash(self) -> None:
        """Let the operator see why a touch does nothing."""
        set_look(self.text, "flash", True)
        self._flash.start()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.unlock.setText(self.tr("HOLD TO UNLOCK"))
        self.text.setText(self.tr("Screen locked. STOP works."))
