"""The window covers the screen, also one that is rotated or replaced, or fits on it."""

import pytest
from PyQt5.QtCore import QRect, Qt
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.window.placement import ScreenPlacement


@pytest.fixture
def window(application):
    window = QWidget()
    window.setMinimumSize(100, 100)
    window.resize(300, 200)
    yield window
    window.close()


def test_a_full_screen_has_no_frame_and_follows_the_screen(window):
    ScreenPlacement(window, full_screen=True).show()
    screen = QGuiApplication.primaryScreen()
    assert window.isFullScreen()
    assert window.windowFlags() & Qt.FramelessWindowHint
    assert window.geometry() == screen.geometry()
    changes = (
        lambda: screen.geometryChanged.emit(screen.geometry()),
        lambda: QGuiApplication.instance().primaryScreenChanged.emit(screen),
    )
    for change in changes:
        window.setGeometry(QRect(5, 5, 200, 200))
        change()
        assert window.geometry() == screen.geometry()


def test_a_window_is_brought_back_onto_the_screen(window):
    free = QGuiApplication.primaryScreen().availableGeometry()
    for place in ((-50, -60), (10_000, 10_000), (3, 4)):
        ScreenPlacement(window, full_screen=False).show()
        window.move(*place)
        QTest.qWait(1)
        assert free.contains(window.frameGeometry()), place
        assert (window.width(), window.height()) == (300, 200)
        window.close()


def test_a_window_that_is_too_large_becomes_smaller(window):
    window.resize(5000, 5000)
    ScreenPlacement(window, full_screen=False).show()
    QTest.qWait(1)
    free = QGuiApplication.primaryScreen().availableGeometry()
    assert free.contains(window.frameGeometry())


def test_the_user_may_later_move_the_window_anywhere(window):
    ScreenPlacement(window, full_screen=False).show()
    for step in range(40):
        window.move(step, step)
    window.move(-50, -50)
    QTest.qWait(1)
    assert window.pos().x() < 0
