"""Pages, and sheets over them that leave the top bar, and with it STOP, free."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QObject, Qt
from PyQt5.QtGui import QHideEvent, QShowEvent
from PyQt5.QtWidgets import QFrame, QWidget

from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import TOP_BAR_PX, look_of
from gpr20_user_interface.touch.guard import note_touch_change


class Page:
    """Follows events and what is known; the pages of the window override what they need."""

    def on_event(self, event: object) -> None:
        """Take an event."""

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; 5 times a second."""

    def draw(self) -> None:
        """Draw what is new; 5 times a second."""

    def show_again(self) -> None:
        """Show the same in another language, theme or size, where it was not written by `say`."""


class Overlay(QFrame):
    """Covers its window below the top bar while it is open; closed at first.

    A dialog of its own could cover STOP, or be lost behind the window. For a moment after it has
    opened or closed, the window takes no touch but that of STOP.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("sheet")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()
        window.installEventFilter(self)

    def open(self) -> None:
        """Cover the tabs."""
        self._cover()
        self.show()
        self.raise_()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        """Qt: it opens."""
        super().showEvent(event)
        note_touch_change(self)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        """Qt: it closes."""
        super().hideEvent(event)
        note_touch_change(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() == QEvent.Type.Resize and self.isVisible():
            self._cover()
        return super().eventFilter(watched, event)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        if event.type() == QEvent.Type.StyleChange:
            if self.isVisible():
                self._cover()
            self.restyle()
        super().changeEvent(event)

    def restyle(self) -> None:
        """Take the sizes and colours of the look, where the style sheet cannot set them."""

    def _cover(self) -> None:
        window = self.parentWidget()
        top_px = look_of(self).px(TOP_BAR_PX)
        self.setGeometry(0, top_px, window.width(), window.height() - top_px)
