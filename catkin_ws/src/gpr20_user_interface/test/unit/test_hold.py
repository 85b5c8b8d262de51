"""A hold acts once after its time, and after nothing but an unbroken touch."""

import pytest
from fake_clock import FakeClock
from finger import Finger
from hypothesis import given
from hypothesis import strategies as st
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QSignalSpy, QTest
from PyQt5.QtWidgets import QFrame, QWidget

from gpr20_user_interface.touch.guard import HOLD_S, MAX_STEP_S, Hold
from gpr20_user_interface.touch.hold_button import HoldButton

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


@pytest.fixture
def button(application):
    window = QWidget()
    window.resize(400, 300)
    button = HoldButton("START")
    button.setParent(window)
    button.setGeometry(100, 100, 200, 72)
    window.show()
    yield button
    window.close()


@pytest.fixture
def held(button):
    return QSignalSpy(button.held)


@pytest.fixture
def finger(button, clock):
    return Finger(button.window(), clock)


def test_a_finger_that_rests_acts_once_and_not_before_its_time(button, held, finger):
    for _bounce in range(3):
        finger.tap(button, 0.9 * HOLD_S)
    assert len(held) == 0
    finger.tap(button, 2.0 * HOLD_S)
    finger.wait(2.0 * HOLD_S)
    assert len(held) == 1


def open_over_it(button, _finger):
    cover = QFrame(button.window())
    cover.setGeometry(0, 0, 400, 300)
    cover.show()


@pytest.mark.parametrize(
    "end",
    [
        open_over_it,
        lambda button, finger: (finger.move(QPoint(200, 290)), finger.move(button)),
        lambda button, _: QTest.mousePress(button, Qt.RightButton),  # a second finger
        lambda button, _: (button.hide(), button.show()),
        lambda button, _: (button.setEnabled(False), button.setEnabled(True)),
    ],
)
def test_a_touch_that_is_broken_does_nothing(button, held, finger, end):
    finger.press(button)
    finger.wait(0.5 * HOLD_S)
    end(button, finger)
    finger.wait(2.0 * HOLD_S)
    assert len(held) == 0


def test_time_as_it_passes_completes_a_hold(application):
    button = HoldButton("START")
    held = QSignalSpy(button.held)
    button.show()
    QTest.mousePress(button, Qt.LeftButton)
    assert len(held) or held.wait(30_000)
    button.close()
