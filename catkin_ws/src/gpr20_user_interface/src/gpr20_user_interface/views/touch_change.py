"""The note that something else is under the finger now."""

from __future__ import annotations

from PyQt5.QtCore import QCoreApplication, QEvent
from PyQt5.QtWidgets import QWidget

TOUCH_CHANGE = QEvent.Type(QEvent.registerEventType())


def note_touch_change(widget: QWidget) -> None:
    """Tell the window of a widget that the widget has opened or closed something.

    The window takes no touch for a moment: one that comes now was meant for what was there
    before.
    """
    QCoreApplication.sendEvent(widget.window(), QEvent(TOUCH_CHANGE))
