"""The window covers the screen, also one that is replaced, or fits on it, and keeps it awake."""

import random
import subprocess

import pytest
from PyQt5.QtCore import QRect, Qt
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QWidget
from run_seed import draws

from gpr20_user_interface.low.screen_saver import ScreenSaver
from gpr20_user_interface.window.placement import Area, ScreenPlacement, fitted


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


def test_no_part_of_any_window_is_outside():
    draw = random.Random(20261122)
    for _ in range(draws(500)):
        free = Area(*(draw.randint(0, 2000) for _ in range(2)), *(draw.randint(300, 2000),) * 2)
        width, height = draw.randint(100, 3000), draw.randint(100, 3000)
        left, top = draw.randint(-3000, 5000), draw.randint(-3000, 5000)
        sides, ends = draw.randint(0, 20), draw.randint(0, 60)
        window = Area(left + sides // 2, top + ends, width, height)
        frame = Area(left, top, width + sides, height + ends)
        place = fitted(window, frame, free)
        assert free.contains(Area(place.left, place.top, place.width + sides, place.height + ends))
        assert place.width <= width and place.height <= height
        if free.contains(frame):
            assert (place.left, place.top, place.width, place.height) == (left, top, width, height)


PRINTED = """Screen Saver:
  prefer blanking:  yes    allow exposures:  yes
  timeout:  {timeout}    cycle:  {cycle}
Colors:
  default colormap:  0x20    BlackPixel:  0x0    WhitePixel:  0xffffff
DPMS (Display Power Management Signaling):
  Standby: 600    Suspend: 600    Off: 600
  DPMS is {power}
  Monitor is On
"""


@pytest.mark.parametrize(
    "printed, restored",
    [
        (PRINTED.format(timeout=600, cycle=300, power="Enabled"), "xset s 600 300 +dpms"),
        (PRINTED.format(timeout=600, cycle=300, power="Disabled"), "xset s 600 300"),
        ("Screen Saver:\n  timeout:  0    cycle:  0\nno DPMS\n", "xset s 0 0"),
    ],
)
def test_what_was_set_before_is_restored_once(printed, restored):
    commands = []

    def run(command):
        commands.append(" ".join(command))
        return printed

    saver = ScreenSaver(run)
    assert saver.switch_off() is None and commands[0] == "xset q"
    assert commands[1].startswith("xset s off")
    for _ in range(2):
        assert saver.restore() is None
        assert commands[2:] == [restored]


@pytest.mark.parametrize(
    "error, reason",
    [
        (FileNotFoundError("xset"), "xset is not installed (Debian package x11-xserver-utils)"),
        (subprocess.TimeoutExpired(["xset", "q"], 3.0), "timed out after 3.0 seconds"),
    ],
)
def test_a_screen_that_cannot_be_set_is_a_note_and_nothing_is_restored(error, reason):
    commands = []

    def run(command):
        commands.append(command)
        raise error

    saver = ScreenSaver(run)
    assert reason in saver.switch_off()
    assert saver.restore() is None and len(commands) == 1
