"""What is seen: the window covers the screen or fits on it, contrast, signs, dimming."""

import random
import subprocess

import pytest
from PyQt5.QtCore import QPoint, QRect, Qt
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QWidget
from run_seed import draws
from view_kit import snapshot
from window_helpers import show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import Mark, TextColours, Theme
from gpr20_user_interface.low.screen_saver import ScreenSaver
from gpr20_user_interface.window.placement import Area, ScreenPlacement, fitted


@pytest.fixture
def widget(application):
    widget = QWidget()
    widget.setMinimumSize(100, 100)
    widget.resize(300, 200)
    yield widget
    widget.close()


def test_a_full_screen_has_no_frame_and_follows_the_screen(widget):
    ScreenPlacement(widget, full_screen=True).show()
    screen = QGuiApplication.primaryScreen()
    assert widget.isFullScreen()
    assert widget.windowFlags() & Qt.FramelessWindowHint
    assert widget.geometry() == screen.geometry()
    changes = (
        lambda: screen.geometryChanged.emit(screen.geometry()),
        lambda: QGuiApplication.instance().primaryScreenChanged.emit(screen),
    )
    for change in changes:
        widget.setGeometry(QRect(5, 5, 200, 200))
        change()
        assert widget.geometry() == screen.geometry()


def test_a_window_is_brought_back_onto_the_screen(widget):
    free = QGuiApplication.primaryScreen().availableGeometry()
    for place in ((-50, -60), (10_000, 10_000), (3, 4)):
        ScreenPlacement(widget, full_screen=False).show()
        widget.move(*place)
        QTest.qWait(1)
        assert free.contains(widget.frameGeometry()), place
        assert (widget.width(), widget.height()) == (300, 200)
        widget.close()


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


AFTER_S = 120.0
# WCAG 2.1: 1.4.6 for text (level AAA), 1.4.11 for what distinguishes a mark from its surroundings.
TEXT_CONTRAST = 7.0
MARK_CONTRAST = 3.0


def luminance(colour):
    channels = [int(colour[start : start + 2], 16) / 255.0 for start in (1, 3, 5)]
    linear = [one / 12.92 if one <= 0.03928 else ((one + 0.055) / 1.055) ** 2.4 for one in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    lighter, darker = sorted((luminance(one), luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def test_every_text_and_every_mark_is_seen():
    for theme in Theme:
        for colours in TextColours:
            assert contrast(*colours.of(theme)) >= TEXT_CONTRAST, colours
        for mark in set(Mark) - {Mark.PAPER}:
            assert contrast(mark.of(theme), Mark.PAPER.of(theme)) >= MARK_CONTRAST, mark


@pytest.fixture
def window(opened):
    window = opened()
    window.settings.dim_choices[2].click()
    show(window, snapshot(SurveyState.SURVEYING))
    return window


def dim(window, clock, shown=None):
    clock.advance(AFTER_S)
    show(window, shown or snapshot(SurveyState.SURVEYING))
    return window.settings.cover.isVisible()


def test_the_first_touch_only_wakes_and_the_next_one_acts(window, finger, clock):
    assert dim(window, clock)
    finger.tap(window.rail.settings)
    assert not window.settings.cover.isVisible()
    assert not window.settings.isVisible()
    finger.tap(window.rail.settings)
    assert window.settings.isVisible()


def test_stop_is_seen_and_acts_on_a_dimmed_screen(window, finger, clock):
    stop, bright = window.top_bar.stop, window.grab().toImage()
    assert dim(window, clock)
    dimmed = window.grab().toImage()
    inside = stop.mapTo(window, QPoint(10, stop.height() // 2))
    assert dimmed.pixelColor(inside) == bright.pixelColor(inside)
    outside = QPoint(window.width() // 2, window.height() - 10)
    assert dimmed.pixelColor(outside).lightness() < 0.3 * bright.pixelColor(outside).lightness()
    finger.tap(stop)
    assert wishes(window) == ["stop"]


def test_an_alarm_a_fault_or_a_notice_is_never_dimmed(window, clock):
    for shown in (snapshot(SurveyState.SURVEYING, alive=False), snapshot(SurveyState.PAUSED)):
        assert not dim(window, clock, shown)
        window.notice.hide()
        assert not dim(window, clock, shown)
        assert dim(window, clock)
        show(window, shown)
        assert not window.settings.cover.isVisible()
        window.notice.hide()
    window.notice.show_notice(refusal_notice(Refused.START, verbatim("no")))
    assert not dim(window, clock)
