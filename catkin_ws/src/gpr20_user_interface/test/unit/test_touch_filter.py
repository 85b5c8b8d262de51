"""Touches as the screen sends them, and what is seen: bounces, holds, lock, dimming, contrast."""

import random

import pytest
from case_kit import each_case
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QSignalSpy, QTest
from PyQt5.QtWidgets import QApplication, QFrame, QPushButton, QWidget
from run_seed import draws
from view_kit import snapshot
from window_helpers import AFTER_S, Finger, place_of, show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import Mark, TextColours, Theme
from gpr20_user_interface.touch.guard import QUIET_S, TouchGuard, TouchTarget
from gpr20_user_interface.touch.hold import HOLD_S, MAX_STEP_S, Hold, HoldButton
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.widgets.widgets import Overlay

# Mostly ticks: a hold needs ten of them without a break.
TICKS = st.sampled_from(["begin", "cancel", *["tick"] * 18])
# Some are longer than what a window sees that is busy.
STEPS = st.lists(st.tuples(TICKS, st.sampled_from([0.05, 0.07, 0.1, 0.3, 5.0])), max_size=80)


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


@pytest.mark.parametrize(
    "end",
    [
        lambda button, _: QFrame(button.window(), geometry=button.window().rect()).show(),
        lambda button, finger: (finger.move(QPoint(200, 290)), finger.move(button)),
        lambda button, _: QTest.mousePress(button, Qt.RightButton),  # a second finger
        lambda button, _: (button.hide(), button.show()),
        lambda button, _: (button.setEnabled(False), button.setEnabled(True)),
        lambda button, finger: (finger.release(button), finger.wait(0.1)),
    ],
)
def test_a_touch_that_is_broken_does_nothing(application, clock, end):
    window, button = QWidget(), HoldButton()
    window.resize(400, 300)
    button.setParent(window)
    button.setGeometry(100, 100, 200, 72)
    window.show()
    held, finger = QSignalSpy(button.held), Finger(window, clock)
    finger.press(button)
    finger.wait(0.5 * HOLD_S)
    end(button, finger)
    finger.wait(2.0 * HOLD_S)
    assert len(held) == 0
    window.close()


NOTICE = refusal_notice(Refused.PAUSE, verbatim("the reason"))


@pytest.fixture
def window(opened):
    window = opened()
    show(window, snapshot(SurveyState.IDLE))
    return window


@each_case("gap_s", [0.0, 0.3])
def test_a_bounce_of_the_touch_that_closes_a_sheet_does_nothing(window, finger, gap_s):
    pressed = []
    for button in window.control.findChildren(QPushButton):
        button.pressed.connect(lambda: pressed.append("a button below"))
    window.notice.show_notice(NOTICE)
    finger.wait(AFTER_S)
    below = place_of(window, window.notice.close_button).center()
    finger.tap(below)
    assert not window.notice.isVisible()
    finger.wait(gap_s)
    finger.tap(below)
    finger.tap(window.control.start)
    assert pressed == [] and not window.start_sheet.isVisible()
    finger.wait(AFTER_S)
    finger.tap(window.control.start)
    assert window.start_sheet.isVisible()
    window.start_sheet.hide()


def test_a_screen_that_is_too_small_can_be_looked_at_and_stops(window, finger):
    show(window, snapshot(SurveyState.SURVEYING))
    window.resize(480, 320)
    QApplication.processEvents()
    finger.wait(AFTER_S)
    assert "800x480" in window.touch_binding.band.text.text()
    for tab in TabName:
        finger.tap(window.rail.tabs[tab])
        finger.wait(AFTER_S)
        assert window.rail.tabs[tab].isChecked()
        for button in window.tabs.currentWidget().findChildren(QPushButton):
            if button.isVisible():
                finger.hold(button)
                finger.wait(AFTER_S)
    assert not any(sheet.isVisible() for sheet in window.findChildren(Overlay))
    # What the robot opens is closed by any touch: its buttons do not act.
    show(window, snapshot(SurveyState.PAUSED))
    window.start_sheet.ask_resume()
    finger.wait(AFTER_S)
    finger.hold(window.start_sheet.hold)
    assert wishes(window) == [] and not window.start_sheet.isVisible()
    show(window, snapshot(SurveyState.SURVEYING))
    finger.tap(window.top_bar.pause)
    finger.tap(window.top_bar.stop)
    assert wishes(window) == ["pause", "stop"]


def test_another_tab_drops_the_touch(window, finger):
    finger.press(window.control.start)
    window.show_tab(TabName.ROBOT)
    window.show_tab(TabName.SURVEY)
    QApplication.processEvents()
    assert not window.control.start.isDown()
    finger.release(window.control.start)
    # Nor does one that comes before anybody can have seen the other tab.
    finger.tap(window.control.start)
    assert not window.start_sheet.isVisible()


def second_finger(window, place):
    """Do what the touch event of a second finger does; tests cannot make one."""
    window.touch_binding.touches.take_fingers([place])
    QApplication.processEvents()


def test_a_second_finger_ends_a_hold_wherever_it_comes(window, finger):
    finger.tap(window.control.start)
    finger.wait(AFTER_S)
    place = place_of(window, window.start_sheet.hold).center()
    finger.press(place)
    finger.wait(0.5)
    second_finger(window, QPoint(20, 400))
    finger.wait(2.0)
    finger.release(place)
    assert wishes(window) == [] and window.start_sheet.isVisible()


def test_stop_notices_a_finger_beside_a_hand_that_rests_on_the_screen(window, finger):
    show(window, snapshot(SurveyState.SURVEYING))
    hand = QPoint(400, 300)
    for number, locked in enumerate((False, True)):
        window.touch_binding.set_locked(locked)
        finger.press(hand)
        second_finger(window, QPoint(20, 400))
        assert wishes(window) == ["stop"] * number
        second_finger(window, place_of(window, window.top_bar.stop).center())
        assert wishes(window) == ["stop"] * (number + 1)
        finger.release(hand)


def test_a_locked_screen_takes_nothing_but_stop_and_the_unlocking(window, finger):
    lock = window.touch_binding
    finger.tap(window.rail.lock)
    # What opens since leaves it free.
    window.stop_warning.open()
    window.notice.show_notice(NOTICE)
    window.refresh()
    unlock = place_of(window, lock.band.unlock).center()
    assert window.childAt(unlock) is lock.band.unlock
    finger.wait(AFTER_S)
    finger.tap(window.notice.close_button)
    assert window.notice.isVisible()
    window.notice.hide()
    finger.wait(10.0)
    finger.tap(window.control.start)
    finger.tap(window.control.area)
    assert not window.start_sheet.isVisible() and not window.values.isVisible()
    finger.tap(lock.band.unlock)
    finger.wait(2.0)
    assert lock.band.isVisible()
    finger.hold(lock.band.unlock)
    assert not lock.band.isVisible()
    finger.wait(AFTER_S)
    finger.tap(window.control.start)
    assert window.start_sheet.isVisible()


STOP, UNLOCK, OTHER = TouchTarget.STOP, TouchTarget.UNLOCK, TouchTarget.OTHER
ACTS = (STOP, UNLOCK, OTHER, "release", "change", "lock", "unlock", "second finger")


def test_in_any_order_nothing_counts_within_the_quiet_time_or_while_locked_but_stop():
    draw, clock = random.Random(7), FakeClock()
    guard = TouchGuard(clock)
    changed_s, locked, taken = -1.0, False, None
    for _ in range(draws(1000)):
        act = draw.choice(ACTS)
        clock.advance(draw.uniform(0.0, 0.6))
        dropped = taken not in (None, STOP)
        if isinstance(act, TouchTarget):
            free = clock.now_s() - changed_s >= QUIET_S and (not locked or act is UNLOCK)
            taken = act if free or act is STOP else None
            assert guard.press(act) is (taken is not None)
        elif act == "release":
            assert guard.release() is (taken is not None)
            taken = None
        else:
            if act == "second finger":
                assert guard.drop() is dropped
            else:
                changed_s, locked = clock.now_s(), {"lock": True, "unlock": False}.get(act, locked)
                assert guard.set_locked(locked) is dropped
            taken = None if dropped else taken
        assert (guard.taken, guard.locked) == (taken is not None, locked)


DIM_S = 120.0
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
def dimming(window):
    window.settings.dim_choices[2].click()
    show(window, snapshot(SurveyState.SURVEYING))
    return window


def dim(window, clock, shown=None):
    clock.advance(DIM_S)
    show(window, shown or snapshot(SurveyState.SURVEYING))
    return window.touch_binding.cover.isVisible()


def test_the_first_touch_only_wakes_and_the_next_one_acts(dimming, finger, clock):
    window = dimming
    assert dim(window, clock)
    finger.tap(window.rail.settings)
    assert not window.touch_binding.cover.isVisible()
    assert not window.settings.isVisible()
    finger.tap(window.rail.settings)
    assert window.settings.isVisible()


def test_stop_is_seen_and_acts_on_a_dimmed_screen(dimming, finger, clock):
    window = dimming
    stop, bright = window.top_bar.stop, window.grab().toImage()
    assert dim(window, clock)
    dimmed = window.grab().toImage()
    inside = stop.mapTo(window, QPoint(10, stop.height() // 2))
    assert dimmed.pixelColor(inside) == bright.pixelColor(inside)
    outside = QPoint(window.width() // 2, window.height() - 10)
    assert dimmed.pixelColor(outside).lightness() < 0.3 * bright.pixelColor(outside).lightness()
    finger.tap(stop)
    assert wishes(window) == ["stop"]


def test_an_alarm_a_fault_or_a_notice_is_never_dimmed(dimming, clock):
    window = dimming
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
