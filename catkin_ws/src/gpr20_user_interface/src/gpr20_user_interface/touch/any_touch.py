"""Notices every touch of the application, whatever becomes of it."""

from __future__ import annotations

from PyQt5.QtCore import QCoreApplication, QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QTouchEvent

from gpr20_user_interface.touch.filter import PRESSES

BEGINS = (*PRESSES, QEvent.Type.TouchBegin, QEvent.Type.Wheel, QEvent.Type.KeyPress)


class AnyTouch(QObject):
    """Emits `touched` when a person touches anything, or presses a key, while it watches.

    The release of a touch that began before is none. It takes no touch away.
    """

    touched = pyqtSignal()

    def watch(self, wanted: bool) -> None:
        """Watch from now on, or no longer: every event of the application costs time."""
        application = QCoreApplication.instance()
        if application is not None:
            application.removeEventFilter(self)
            if wanted:
                application.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: anything happens."""
        if event.type() in BEGINS or _is_another_finger(event):
            self.touched.emit()
        return False


def _is_another_finger(event: QEvent) -> bool:
    """Return whether a finger comes beside one that is there: Qt makes no press of it."""
    pressed = Qt.TouchPointState.TouchPointPressed
    return isinstance(event, QTouchEvent) and any(
        one.state() == pressed for one in event.touchPoints()
    )
