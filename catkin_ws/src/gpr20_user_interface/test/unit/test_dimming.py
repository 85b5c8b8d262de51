"""The screen is dimmed after a while; the touch that wakes it does nothing else."""

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import close, opened_window, show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.touch.dimming import Dimming
from gpr20_user_interface.window.rail import TabName

NEVER, AFTER_S = None, 120.0


def test_it_dims_after_the_time_without_a_touch(clock):
    dimming = Dimming(clock, AFTER_S)
    for _ in range(3):
        clock.advance(AFTER_S - 1.0)
        dimming.refresh(awake=False)
        assert not dimming.dimmed
        assert not dimming.wake()
    clock.advance(AFTER_S)
    dimming.refresh(awake=False)
    assert dimming.dimmed
    assert dimming.wake()
    assert not dimming.wake()


def test_it_never_dims_if_never_is_chosen(clock):
    dimming = Dimming(clock, NEVER)
    clock.advance(1e6)
    dimming.refresh(awake=False)
    assert not dimming.dimmed
    dimming.set_after(AFTER_S)
    clock.advance(AFTER_S)
    dimming.refresh(awake=False)
    assert dimming.dimmed


def test_what_must_be_seen_wakes_it_and_keeps_it_awake(clock):
    dimming = Dimming(clock, AFTER_S)
    clock.advance(AFTER_S)
    dimming.refresh(awake=False)
    dimming.refresh(awake=True)
    assert not dimming.dimmed
    clock.advance(AFTER_S - 1.0)
    dimming.refresh(awake=False)
    assert not dimming.dimmed


@pytest.fixture
def window(application, clock):
    window = opened_window(application, clock=clock)
    window.settings.dim_choices[2].click()
    show(window, snapshot(SurveyState.SURVEYING))
    yield window
    close(window)


def dim(window, clock, shown=None):
    clock.advance(AFTER_S)
    show(window, shown or snapshot(SurveyState.SURVEYING))
    return window.settings.cover.isVisible()


def touch(window, widget):
    """Touch the screen where a widget is, as a finger does."""
    place = widget.mapTo(window, widget.rect().center())
    QTest.mouseClick(window.windowHandle(), Qt.LeftButton, pos=place)


def test_the_first_touch_only_wakes_and_the_next_one_acts(window, clock):
    window.show_tab(TabName.ROBOT)
    assert dim(window, clock)
    touch(window, window.rail.settings)
    assert not window.settings.cover.isVisible()
    assert not window.settings.isVisible()
    touch(window, window.rail.settings)
    assert window.settings.isVisible()


def test_stop_is_seen_and_acts_on_a_dimmed_screen(window, clock):
    bright = window.grab().toImage()
    assert dim(window, clock)
    dimmed = window.grab().toImage()
    stop = window.top_bar.stop
    inside = stop.mapTo(window, QPoint(10, stop.height() // 2))
    assert dimmed.pixelColor(inside) == bright.pixelColor(inside)
    outside = QPoint(window.width() // 2, window.height() - 10)
    assert dimmed.pixelColor(outside).lightness() < 0.3 * bright.pixelColor(outside).lightness()
    touch(window, stop)
    assert wishes(window) == ["stop"]
    assert not window.settings.cover.isVisible()


def test_an_alarm_a_fault_or_a_notice_is_never_dimmed(window, clock):
    for shown in (
        snapshot(SurveyState.SURVEYING, alive=False),
        snapshot(SurveyState.FAILED),
        snapshot(SurveyState.PAUSED),
    ):
        assert not dim(window, clock, shown)
        window.notice.hide()
        assert not dim(window, clock, shown)
        assert dim(window, clock)
        show(window, shown)
        assert not window.settings.cover.isVisible()
        window.notice.hide()
    window.notice.show_notice(refusal_notice(Refused.START, verbatim("no")))
    assert not dim(window, clock)


def test_the_cover_follows_the_size_of_the_window(window, clock):
    assert dim(window, clock)
    window.resize(640, 400)
    assert window.settings.cover.size() == window.size()
