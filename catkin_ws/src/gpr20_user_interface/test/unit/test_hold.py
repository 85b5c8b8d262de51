"""A hold acts once after its time, and after nothing but an unbroken touch."""

import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st
from PyQt5.QtCore import QEvent, QPoint, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QSignalSpy, QTest
from PyQt5.QtWidgets import QApplication, QFrame, QWidget

from gpr20_user_interface.touch.guard import HOLD_S, MAX_STEP_S, Hold
from gpr20_user_interface.touch.hold_button import TICK_MS, HoldButton

# Mostly ticks: a hold needs ten of them without a break.
ACTS = ["begin", "cancel", *["tick"] * 18]
STEPS = st.lists(st.tuples(st.sampled_from(ACTS), st.floats(0.0, 0.3)), max_size=80)


@given(STEPS)
def test_nothing_but_a_second_without_a_break_completes_a_hold(steps):
    clock = FakeClock()
    hold = Hold(clock)
    seen_s = None  # how much of an unbroken touch the window has seen
    looked_s = 0.0
    for act, seconds in steps:
        clock.advance(seconds)
        now_s = clock.now_s()
        if act == "tick":
            if seen_s is not None:
                seen_s += min(now_s - looked_s, MAX_STEP_S)
            complete = seen_s is not None and seen_s >= HOLD_S
            assert hold.tick() is complete
            seen_s = None if complete else seen_s
        elif act == "begin":
            hold.begin()
            seen_s = 0.0 if seen_s is None else None
        else:
            hold.cancel()
            seen_s = None
        looked_s = now_s


class Held:
    """A button in a window, with a clock that only the test moves."""

    def __init__(self):
        self.window = QWidget()
        self.window.resize(400, 300)
        self.clock = FakeClock()
        self.button = HoldButton("START", self.clock)
        self.button.setParent(self.window)
        self.button.setGeometry(100, 100, 200, 72)
        self.held = QSignalSpy(self.button.held)
        self.window.show()

    def wait(self, seconds):
        for _ in range(round(seconds * 1000.0 / TICK_MS)):
            self.clock.advance(TICK_MS / 1000.0)
            self.button.tick()

    def press(self, button=Qt.LeftButton):
        QTest.mousePress(self.button, button)

    def move(self, place):
        moved = QMouseEvent(QEvent.MouseMove, place, Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
        QApplication.sendEvent(self.button, moved)


@pytest.fixture
def held(application):
    held = Held()
    yield held
    held.window.close()


def test_a_finger_that_rests_acts_once_and_not_before_its_time(held):
    for _bounce in range(3):
        held.press()
        held.wait(0.9 * HOLD_S)
        QTest.mouseRelease(held.button, Qt.LeftButton)
    assert len(held.held) == 0
    held.press()
    held.wait(2.0 * HOLD_S)
    QTest.mouseRelease(held.button, Qt.LeftButton)
    held.wait(2.0 * HOLD_S)
    assert len(held.held) == 1


def open_over_it(held):
    cover = QFrame(held.window)
    cover.setGeometry(0, 0, 400, 300)
    cover.show()


@pytest.mark.parametrize(
    "end",
    [
        open_over_it,
        lambda held: (held.move(QPoint(100, 300)), held.move(QPoint(100, 30))),
        lambda held: held.press(Qt.RightButton),  # a second finger
        lambda held: (held.button.hide(), held.button.show()),
        lambda held: (held.button.setEnabled(False), held.button.setEnabled(True)),
    ],
)
def test_a_touch_that_is_broken_does_nothing(held, end):
    held.press()
    held.wait(0.5 * HOLD_S)
    end(held)
    held.wait(2.0 * HOLD_S)
    assert len(held.held) == 0


def test_time_as_it_passes_completes_a_hold(application):
    button = HoldButton("START")
    held = QSignalSpy(button.held)
    button.show()
    QTest.mousePress(button, Qt.LeftButton)
    assert len(held) or held.wait(30_000)
    button.close()
