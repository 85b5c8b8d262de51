import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtCore import QEvent, QPoint, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from window_helpers import application

from gpr20_user_interface.views.hold_button import HOLD_MS, HoldButton

__all__ = ["application"]


@pytest.fixture
def button(application):
    button = HoldButton("START")
    button.times = []
    button.held.connect(lambda: button.times.append(1))
    button.resize(200, 72)
    button.show()
    yield button
    button.close()


def test_a_tap_does_nothing(button):
    QTest.mouseClick(button, Qt.LeftButton)
    QTest.qWait(HOLD_MS + 200)
    assert not button.times


def test_a_finger_that_rests_acts_once(button):
    QTest.mousePress(button, Qt.LeftButton)
    QTest.qWait(HOLD_MS + 300)
    QTest.mouseRelease(button, Qt.LeftButton)
    assert button.times == [1]


def test_a_finger_that_leaves_does_nothing(button):
    QTest.mousePress(button, Qt.LeftButton)
    outside = QPoint(100, 300)
    moved = QMouseEvent(QEvent.MouseMove, outside, Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(button, moved)
    QTest.qWait(HOLD_MS + 300)
    assert not button.times
