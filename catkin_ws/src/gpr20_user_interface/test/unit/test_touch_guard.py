from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st

from gpr20_user_interface.touch.guard import QUIET_S, TouchGuard, TouchTarget

STOP, UNLOCK, OTHER = TouchTarget.STOP, TouchTarget.UNLOCK, TouchTarget.OTHER


ACTS = st.lists(
    st.tuples(
        st.sampled_from(
            ["stop", "unlock key", "other", "release", "change", "lock", "unlock", "second finger"]
        ),
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
        elif act == "second finger":
            assert guard.note_second_finger() is (began_s is not None and not on_stop)
            if not on_stop:
                began_s = None
        else:
            counted = began_s is not None and not on_stop and began_s > changed_s
            change = {"change": guard.note_change, "lock": guard.lock, "unlock": guard.unlock}
            assert change[act]() is counted
            changed_s = now_s
            locked = {"lock": True, "unlock": False}.get(act, locked)
            if not on_stop:
                began_s = None
        assert guard.taken is (began_s is not None and (on_stop or began_s > changed_s))
        assert guard.locked is locked
