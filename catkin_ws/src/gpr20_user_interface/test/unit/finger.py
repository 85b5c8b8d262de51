"""A finger on the screen of a window: its touches take the way of a real one."""

from PyQt5.QtCore import QPoint, QRect, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from gpr20_user_interface.touch.guard import QUIET_S
from gpr20_user_interface.touch.hold_button import HoldButton

STEP_S = 0.05
# Touches count again after something has opened or closed.
AFTER_S = QUIET_S + 0.05


class Finger:
    """Touches a window through its screen, so that nothing of the window is left out.

    Time passes only by `wait`.
    """

    def __init__(self, window, clock):
        self._window = window
        self._clock = clock
        self._held = window.findChildren(HoldButton)
        for button in self._held:
            button.set_clock(clock)
        QApplication.processEvents()
        # The window has just opened.
        self.wait(1.0)

    def wait(self, seconds):
        """Let time pass; buttons that are held notice it."""
        while seconds > 0.0:
            self._clock.advance(min(STEP_S, seconds))
            seconds -= STEP_S
            for button in self._held:
                button.tick()

    def press(self, where):
        QTest.mousePress(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def move(self, where):
        QTest.mouseMove(self._screen, self._place(where))

    def release(self, where):
        QTest.mouseRelease(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def tap(self, where, seconds=0.03):
        place = self._place(where)
        self.press(place)
        self.wait(seconds)
        self.release(place)

    def hold(self, where, seconds=1.1):
        self.tap(where, seconds)

    @property
    def _screen(self):
        return self._window.windowHandle()

    def _place(self, where):
        return where if isinstance(where, QPoint) else place_of(self._window, where).center()


def place_of(window, widget):
    """Return where a widget is in its window."""
    return QRect(widget.mapTo(window, QPoint()), widget.size())
