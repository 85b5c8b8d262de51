"""A button for what must not happen by accident: it acts only after it was held."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import QEvent, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QColor, QHideEvent, QMouseEvent, QPainter, QPaintEvent
from PyQt5.QtWidgets import QPushButton

from gpr20_common.low.clock import Clock
from gpr20_user_interface.look.look import TextColours, look_of

TICK_MS = 50
# How long a button must be held [s].
HOLD_S = 1.0
# A window that was busy does not know whether the finger was there all the time: what lies
# between two looks counts as this time [s] at most.
MAX_STEP_S = 0.1


class Hold:
    """Measures how long a finger holds a button without a break."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._held_s: Optional[float] = None
        self._looked_s = 0.0

    @property
    def active(self) -> bool:
        """Whether a finger holds the button."""
        return self._held_s is not None

    @property
    def fraction(self) -> float:
        """How much of the time has passed, 0 to 1."""
        return 0.0 if self._held_s is None else min(1.0, self._held_s / HOLD_S)

    def begin(self) -> None:
        """Note that a finger presses; one that comes to another finger ends the hold."""
        if self.active:
            self.cancel()
            return
        self._held_s = 0.0
        self._looked_s = self._clock.now_s()

    def cancel(self) -> None:
        """Note that the finger has left, or that what is under it has changed."""
        self._held_s = None

    def tick(self) -> bool:
        """Look at the clock; return whether the hold is complete. Each hold is so once."""
        if self._held_s is None:
            return False
        now_s = self._clock.now_s()
        self._held_s += min(now_s - self._looked_s, MAX_STEP_S)
        self._looked_s = now_s
        if self._held_s < HOLD_S:
            return False
        self.cancel()
        return True


class HoldButton(QPushButton):
    """Emits `held` when a finger has rested on it; a tap does nothing.

    It fills while it is held. A finger that leaves it, even for a moment, has to begin again.
    """

    held = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("hold")
        # A key must not press it.
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._hold = Hold(Clock())
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.timeout.connect(self.tick)

    def set_clock(self, clock: Clock) -> None:
        """Measure the time with another clock."""
        self._cancel()
        self._hold = Hold(clock)

    def tick(self) -> None:
        """Look at the clock; act if the button was held long enough."""
        if not self._hold.active:
            return
        if not self._is_seen():
            # Something has opened over it under the finger.
            self._cancel()
        complete = self._hold.tick()
        self.update()
        if complete:
            self._timer.stop()
            self.setDown(False)
            self.held.emit()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger, or a second one."""
        super().mousePressEvent(event)
        self._hold.begin()
        if self._hold.active:
            self._timer.start()
        else:
            self._cancel()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger that comes soon after another touch."""
        self.mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger that leaves the button does not hold it, even if it comes back."""
        super().mouseMoveEvent(event)
        if not self.rect().contains(event.pos()):
            self._cancel()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: the finger has left."""
        self._cancel()
        super().mouseReleaseEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        """Qt: the button is not there any more."""
        self._cancel()
        super().hideEvent(event)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the button has changed."""
        if event.type() == QEvent.Type.EnabledChange:
            self._cancel()
        super().changeEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: fill the button as time passes."""
        super().paintEvent(event)
        if self._hold.fraction > 0.0:
            # The text once more: it must be readable on both colours.
            filled = look_of(self).text(TextColours.PRESSED)
            painter = QPainter(self)
            painter.setClipRect(0, 0, round(self.width() * self._hold.fraction), self.height())
            painter.fillRect(self.rect(), QColor(filled.ground))
            painter.setPen(QColor(filled.ink))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.text())

    def _cancel(self) -> None:
        self._timer.stop()
        self._hold.cancel()
        self.update()

    def _is_seen(self) -> bool:
        window = self.window()
        middle = self.rect().center()
        return window is self or window.childAt(self.mapTo(window, middle)) is self
