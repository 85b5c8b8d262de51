import pytest
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st

from gpr20_user_interface.mid.touch_guard import QUIET_S, TouchGuard, TouchTarget

STOP, UNLOCK, OTHER = TouchTarget.STOP, TouchTarget.UNLOCK, TouchTarget.OTHER


@pytest.fixture
def guard(clock):
    return TouchGuard(clock)


def tap(guard, target=OTHER):
    """Return whether a short touch counts from its beginning to its end."""
    return guard.press(target) and guard.release()


def test_a_touch_counts(guard):
    assert tap(guard)


@pytest.mark.parametrize("seconds", [0.0, 0.09, 0.12, 0.399])
def test_no_touch_counts_right_after_something_opened_or_closed(guard, clock, seconds):
    guard.note_change()
    clock.advance(seconds)
    assert not tap(guard)
    assert not tap(guard, UNLOCK)
    assert tap(guard, STOP)
    clock.advance(QUIET_S - seconds + 0.01)
    assert tap(guard)


def test_a_touch_that_began_before_the_change_is_dropped(guard, clock):
    guard.press(OTHER)
    assert guard.note_change()
    assert not guard.taken
    clock.advance(2.0 * QUIET_S)
    assert not guard.taken
    assert not guard.release()
    assert tap(guard)


def test_a_touch_that_began_too_early_does_not_count_later(guard, clock):
    guard.note_change()
    clock.advance(0.3)
    guard.press(OTHER)
    clock.advance(2.0)
    assert not guard.taken
    assert not guard.release()


def test_a_change_does_not_take_stop_from_under_the_finger(guard):
    guard.press(STOP)
    assert not guard.note_change()
    assert guard.release()


def test_a_locked_screen_takes_only_stop_and_the_unlocking(guard, clock):
    guard.lock()
    clock.advance(10.0)
    assert [tap(guard, target) for target in (STOP, UNLOCK, OTHER)] == [True, True, False]
    guard.unlock()
    assert not tap(guard)
    clock.advance(QUIET_S + 0.01)
    assert tap(guard)


ACTS = st.lists(
    st.tuples(
        st.sampled_from(["stop", "unlock key", "other", "release", "change", "lock", "unlock"]),
        st.floats(0.0, 0.6),
    ),
    max_size=60,
)


@given(ACTS)
def test_in_any_order_nothing_counts_within_the_quiet_time_or_while_locked_but_stop(acts):
    clock = FakeClock()
    guard = TouchGuard(clock)
    changed_s, locked, began_s, on_stop = -1.0, False, None, False
    for act, seconds in acts:
        clock.advance(seconds)
        now_s = clock.now_s()
        if act in ("stop", "unlock key", "other"):
            target = {"stop": STOP, "unlock key": UNLOCK, "other": OTHER}[act]
            free = now_s - changed_s >= QUIET_S and (not locked or target is UNLOCK)
            assert guard.press(target) is (target is STOP or free)
            began_s, on_stop = (now_s, target is STOP) if target is STOP or free else (None, False)
        elif act == "release":
            counts = began_s is not None and (on_stop or began_s > changed_s)
            assert guard.release() is counts
            began_s = None
        else:
            counted = began_s is not None and not on_stop and began_s > changed_s
            change = {"change": guard.note_change, "lock": guard.lock, "unlock": guard.unlock}
            assert change[act]() is counted
            changed_s = now_s
            locked = {"lock": True, "unlock": False}.get(act, locked)
            if not on_stop:
                began_s = None
