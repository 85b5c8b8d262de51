"""One browser at a time is in control, as long as the person at the robot allows it."""

from __future__ import annotations

import contextlib
from typing import Any, List, Set, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from web_kit import ManualClock

from gpr20_web.calls import Person, Role
from gpr20_web.faults import NotAllowedError
from gpr20_web.mid.presses import ABSENT_S, Lease

ANA, BEN = (Person(name, Role.CONTROL, f"session of {name}", "") for name in "ab")
TWIN = Person(ANA.name, ANA.role, "other session", "")
ACTS = st.sampled_from(["take", "release", "leave", "come"])
STEPS = st.one_of(
    st.tuples(ACTS, st.sampled_from([ANA, BEN, TWIN])),
    st.tuples(st.just("wait"), st.floats(0.0, 50.0)),
    st.tuples(st.just("allow"), st.booleans()),
)


@given(st.lists(STEPS, max_size=40))
def test_control_passes_to_another_only_by_leaving_or_when_it_was_not_allowed(
    steps: List[Tuple[str, Any]],
) -> None:
    clock, allowed, was_open = ManualClock(), True, True
    present: Set[str] = {one.session for one in (ANA, BEN, TWIN)}
    lease = Lease(clock, lambda session: session in present)
    for what, argument in steps:
        before = lease.holder
        if what == "wait":
            clock.time_s += argument
        elif what == "allow":
            allowed = argument
        elif what == "leave":
            present.discard(argument.session)
        elif what == "come":
            present.add(argument.session)
        elif what == "release":
            lease.release(argument)
            assert lease.holder is None or lease.holder is before
        else:
            with contextlib.suppress(NotAllowedError):
                lease.take(argument, allowed)
                assert lease.holder is argument
        lease.refresh(allowed)
        after = lease.holder
        if before is not None and after is not before and not was_open:
            assert (what, argument) == ("release", before) or before.session not in present
        # Allowed when it was taken, and since.
        was_open = after is None or not allowed or (was_open and after is before)
        for one in (ANA, BEN, TWIN):
            assert lease.has(one) is (one is after)


def test_a_tab_that_is_closed_or_a_link_that_is_lost_gives_control_up() -> None:
    clock, present = ManualClock(), {ANA.session}
    lease = Lease(clock, lambda session: session in present)
    with pytest.raises(NotAllowedError, match="this page is not in control"):
        lease.check(ANA)
    lease.take(ANA, True)
    with pytest.raises(NotAllowedError, match="another page is in control: a"):
        lease.take(BEN, True)
    clock.time_s += 10 * ABSENT_S
    lease.refresh(True)
    present.clear()
    for wait_s, is_held in ((ABSENT_S, True), (0.1, False)):
        clock.time_s += wait_s
        lease.refresh(True)
        assert lease.has(ANA) is is_held
