"""What lies over the window and takes its touches: the lock, and the dark of a dimmed screen."""

from __future__ import annotations

from typing import Callable, Optional, Sequence

from PyQt5.QtCore import QPoint, QRect, Qt, pyqtSignal
from PyQt5.QtGui import QRegion
from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import look_of
from gpr20_user_interface.touch.guard import TouchFilter, TouchGuard
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.widgets import Overlay, new_label, row, say


class DimCover(QWidget):
    """Darkens a window some time after the last touch.

    Args:
        window: The window.
        stop: Its button STOP, which is not covered.
        clock: Measures the time.
        after_s: Returns the time after the last touch [s]; None: never.

    Attributes:
        dimmed: Whether the screen is dimmed.
    """

    def __init__(
        self, window: QWidget, stop: QWidget, clock: Clock, after_s: Callable[[], Optional[float]]
    ) -> None:
        super().__init__(window)
        self._stop, self._clock, self._after_s = stop, clock, after_s
        self._touched_s = clock.now_s()
        self.dimmed = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setObjectName("dark")
        self.hide()

    def refresh(self, awake: bool) -> None:
        """Dim the screen when it is time; not if something must be seen, such as an alarm."""
        after_s = self._after_s()
        if awake:
            self.wake()
        elif after_s is not None:
            self.dimmed = self._clock.now_s() - self._touched_s >= after_s
        self._show()

    def wake(self) -> bool:
        """Note a touch.

        Returns:
            Whether it only wakes the screen: it must have no other effect, because nobody sees
            well what it would act on. STOP always acts.
        """
        was_dimmed, self.dimmed = self.dimmed, False
        self._touched_s = self._clock.now_s()
        self._show()
        return was_dimmed

    def _show(self) -> None:
        if self.dimmed:
            self.setGeometry(self.parentWidget().rect())
            corner = self._stop.mapTo(self.parentWidget(), QPoint(0, 0))
            bright = QRect(corner, self._stop.size()) if self._stop.isVisible() else QRect()
            self.setMask(QRegion(self.rect()) - QRegion(bright))
            self.raise_()
        self.setVisible(self.dimmed)


BAND_PX = 62
# These wait for the operator.
AWAKE = (SurveyState.PAUSED, SurveyState.FAILED)


class LockBand(QWidget):
    """Says why touches have no effect, over the bottom of a locked or a small screen.

    There are buttons, which do not act then; the title of a card stays in sight.
    """

    unlocked = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("lock_band")
        self.unlock = HoldButton()
        say(self.unlock, Message("HOLD TO UNLOCK"))
        self.unlock.held.connect(self.unlocked)
        self.text = new_label("locked", wraps=True)
        self.locked = False
        # Not where the lock is: a touch that comes twice must not begin the hold.
        self.setLayout(row((self.text, 1), self.unlock))
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()

    def show_state(self, locked: bool) -> None:
        """Show whether the screen is locked; a screen that is too small always says so."""
        self.locked = locked
        self.unlock.setVisible(locked)
        small = Message("This screen is too small to operate the robot. Use 800x480 or larger.")
        say(self.text, Message("Screen locked. STOP works.") if locked else small)
        self.setVisible(locked or not look_of(self).touchable)
        self.cover()

    def cover(self) -> None:
        """Lie over everything that is there, also over what has opened since."""
        window, height_px = self.parentWidget(), look_of(self).px(BAND_PX)
        self.setGeometry(0, window.height() - height_px, window.width(), height_px)
        self.raise_()


class TouchBinding:
    """Guards every touch of a window; it is made when everything else in the window exists.

    Args:
        window: The window.
        stop: STOP, which always works.
        views: Work on a screen that is too small to operate the robot.
        notices: What must be seen: while one is open the screen is not dimmed.
        dim_after_s: Returns the time without a touch after which it is dimmed [s]; None: never.
        clock: Measures the time after a touch, and after something has opened or closed.

    Attributes:
        band: What a locked screen shows.
        cover: What dims the screen.
        touches: Takes the touches.
    """

    def __init__(
        self,
        window: QWidget,
        stop: QPushButton,
        views: Sequence[QWidget],
        notices: Sequence[QWidget],
        dim_after_s: Callable[[], Optional[float]],
        clock: Clock,
    ) -> None:
        self._window, self._notices = window, notices
        self.cover = DimCover(window, stop, clock, dim_after_s)
        self.band = LockBand(window)
        self.band.unlock.set_clock(clock)
        self.band.unlocked.connect(lambda: self.set_locked(False))
        self.touches = TouchFilter(
            *(window, TouchGuard(clock), stop, self.band.unlock, views, self.cover.wake)
        )
        self.touches.watch_pages()
        self.touches.too_small.connect(self._on_too_small)

    def show_state(self, snapshot: Snapshot) -> None:
        """Dim the screen when it is time, not while there is something to see."""
        waits = snapshot.state is not None and snapshot.state.code in AWAKE
        seen = any(notice.isVisible() for notice in self._notices)
        level = condition_of(snapshot).level
        self.cover.refresh(waits or seen or level in (JobLevel.ATTENTION, JobLevel.FAULT))
        self.band.cover()

    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the screen, and show which it is."""
        self.touches.set_locked(locked)
        self.band.show_state(locked)

    def _on_too_small(self) -> None:
        # Nothing on a small screen could close them.
        for overlay in self._window.findChildren(Overlay):
            if isinstance(overlay, Overlay):
                overlay.hide()
