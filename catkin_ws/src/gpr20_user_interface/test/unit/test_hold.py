import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st

from gpr20_user_interface.touch.guard import HOLD_S, MAX_STEP_S, Hold

# Slightly more than the ticks of a window that keeps up.
TICK_S = 0.033


@pytest.fixture
def hold(clock):
    return Hold(clock)


def wait(hold, clock, seconds, step_s=TICK_S):
    """Let time pass in ticks; return how often the hold was completed."""
    completed, left_s = 0, seconds
    while left_s > 0.0:
        clock.advance(min(step_s, left_s))
        left_s -= step_s
        completed += hold.tick()
    return completed


def test_a_finger_that_stays_completes_the_hold_once(hold, clock):
    hold.begin()
    assert wait(hold, clock, 0.97) == 0
    assert 0.9 < hold.fraction < 1.0
    assert wait(hold, clock, 5.0) == 1
    assert (hold.active, hold.fraction) == (False, 0.0)


def test_a_window_that_was_busy_does_not_take_a_tap_for_a_hold(hold, clock):
    hold.begin()
    # The finger has left long ago, but the window comes to its release only after this tick.
    clock.advance(3.0)
    assert not hold.tick()
    assert hold.fraction <= MAX_STEP_S / HOLD_S


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
