import pytest
from fake_clock import FakeClock
from PyQt5.QtCore import QEvent, QPoint, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QFrame, QWidget

from gpr20_user_interface.touch.guard import HOLD_S
from gpr20_user_interface.touch.hold_button import TICK_MS, HoldButton


class Held:
    """A button in a window, with a clock that only the test moves."""

    def __init__(self):
        self.window = QWidget()
        self.window.resize(400, 300)
        self.clock = FakeClock()
        self.button = HoldButton("START", self.clock)
        self.button.setParent(self.window)
        self.button.setGeometry(100, 100, 200, 72)
        self.times = 0
        self.button.held.connect(self.note)
        self.window.show()

    def note(self):
        self.times += 1

    def wait(self, seconds):
        for _ in range(round(seconds * 1000.0 / TICK_MS)):
            self.clock.advance(TICK_MS / 1000.0)
            self.button.tick()

    def press(self):
        QTest.mousePress(self.button, Qt.LeftButton)

    def release(self):
        QTest.mouseRelease(self.button, Qt.LeftButton)

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
        held.release()
    assert held.times == 0
    held.press()
    held.wait(2.0 * HOLD_S)
    assert held.times == 1
    held.release()
    held.wait(2.0 * HOLD_S)
    assert held.times == 1


def test_a_button_that_is_held_fills(held):
    def colour():
        return held.window.grab().toImage().pixelColor(120, 110).name()

    empty = colour()
    held.press()
    held.wait(0.5 * HOLD_S)
    assert colour() != empty
    held.release()
    assert colour() == empty


def test_a_finger_that_leaves_does_nothing_even_if_it_comes_back(held):
    held.press()
    held.wait(0.5 * HOLD_S)
    held.move(QPoint(100, 300))
    held.move(QPoint(100, 30))
    held.wait(2.0 * HOLD_S)
    assert held.times == 0


def test_a_second_finger_ends_the_hold(held):
    held.press()
    held.wait(0.5 * HOLD_S)
    QTest.mousePress(held.button, Qt.RightButton)
    held.wait(2.0 * HOLD_S)
    assert held.times == 0


def test_what_opens_over_the_button_ends_the_hold(held):
    held.press()
    held.wait(0.5 * HOLD_S)
    cover = QFrame(held.window)
    cover.setGeometry(0, 0, 400, 300)
    cover.show()
    held.wait(2.0 * HOLD_S)
    assert held.times == 0


def test_a_button_that_goes_away_ends_the_hold(held):
    for end in (held.button.hide, lambda: held.button.setEnabled(False)):
        held.press()
        held.wait(0.5 * HOLD_S)
        end()
        held.button.setEnabled(True)
        held.button.show()
        held.wait(2.0 * HOLD_S)
        assert held.times == 0
        held.release()


def test_time_as_it_passes_completes_a_hold(application):
    button = HoldButton("START")
    times = []
    button.held.connect(lambda: times.append(1))
    button.show()
    QTest.mousePress(button, Qt.LeftButton)
    QTest.qWait(round(1400 * HOLD_S))
    button.close()
    assert times == [1]
