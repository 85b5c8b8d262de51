"""What is seen: the window covers the screen or fits on it, contrast, signs, dimming."""

import pytest
from PyQt5.QtCore import QPoint, QRect, Qt
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QApplication
from view_kit import snapshot
from window_helpers import show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import Mark, TextColours, Theme


def test_a_full_screen_has_no_frame_and_follows_the_screen(window):
    window.show_on_screen(full_screen=True)
    screen = QGuiApplication.primaryScreen()
    assert window.isFullScreen() and window.windowFlags() & Qt.FramelessWindowHint
    for change in (
        lambda: screen.geometryChanged.emit(screen.geometry()),
        lambda: QGuiApplication.instance().primaryScreenChanged.emit(screen),
    ):
        window.setGeometry(QRect(5, 5, 500, 400))
        change()
        assert window.geometry() == screen.geometry()


def test_a_window_is_not_larger_than_the_screen(window):
    free = QGuiApplication.primaryScreen().availableGeometry().size()
    window.resize(10_000, 10_000)
    window.show_on_screen(full_screen=False)
    assert window.size() == free


def test_an_open_sheet_follows_the_window_and_leaves_the_top_bar_free(window):
    window.settings.open()
    for width, height in ((1280, 800), (640, 384), (800, 480)):
        window.resize(width, height)
        QApplication.processEvents()
        bar, sheet = window.top_bar.geometry(), window.settings.geometry()
        assert sheet == QRect(0, bar.bottom() + 1, width, height - bar.height())


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
    return window.touch_binding.cover.isVisible()


def test_the_first_touch_only_wakes_and_the_next_one_acts(window, finger, clock):
    assert dim(window, clock)
    finger.tap(window.rail.settings)
    assert not window.touch_binding.cover.isVisible()
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
        assert not window.touch_binding.cover.isVisible()
        window.notice.hide()
    window.notice.show_notice(refusal_notice(Refused.START, verbatim("no")))
    assert not dim(window, clock)
