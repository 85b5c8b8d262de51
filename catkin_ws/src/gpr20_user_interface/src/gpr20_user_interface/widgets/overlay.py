"""Pages, and sheets over them that leave the top bar, and with it STOP, free."""

from __future__ import annotations

from PyQt5.QtCore import Qt
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

    def open(self) -> None:
        """Cover the tabs."""
        self.cover()
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

    def cover(self) -> None:
        """Lie below the top bar, also after the window has another size."""
        window = self.parentWidget()
        top_px = look_of(self).px(TOP_BAR_PX)
        self.setGeometry(0, top_px, window.width(), window.height() - top_px)
