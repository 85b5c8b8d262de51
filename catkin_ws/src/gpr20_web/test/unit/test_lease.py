"""One browser at a time is in control, as long as the person at the robot allows it."""

from __future__ import annotations

import contextlib
from typing import Set

import pytest
from hypothesis import given
from hypothesis import strategies as st
from web_kit import ManualClock

from gpr20_web.calls import Person, Role
from gpr20_web.errors import NotAllowedError
from gpr20_web.mid.lease import ABSENT_S, Lease

ANA, BEN, EVA = (Person(name, Role.CONTROL, f"session of {name}", "") for name in "abe")


class Room:
    def __init__(self) -> None:
        self.time, self.allowed = ManualClock(), True
        self.present: Set[str] = {ANA.session, BEN.session, EVA.session}
        self.lease = Lease(self.time, lambda session: session in self.present)

    def wait(self, time_s: float) -> None:
        self.time.time_s += time_s
        self.lease.refresh(self.allowed)

    def take(self, person: Person) -> None:
        self.lease.take(person, self.allowed)


def test_who_takes_control_has_it_while_the_person_at_the_robot_allows_it() -> None:
    room = Room()
    with pytest.raises(NotAllowedError, match="this page is not in control"):
        room.lease.check(ANA)
    room.take(ANA)
    room.lease.check(ANA)
    twin = Person(ANA.name, ANA.role, "other session", "")
    for other in (BEN, twin):
        with pytest.raises(NotAllowedError, match="another page is in control: a"):
            room.take(other)
    # It stays hers until another one takes it.
    room.allowed = False
    room.wait(1.0)
    assert room.lease.has(ANA)
    room.allowed = True
    room.take(BEN)
    assert room.lease.has(BEN)
    room.lease.release(ANA)
    assert room.lease.has(BEN)
    room.lease.release(BEN)
    assert room.lease.holder is None


def test_a_tab_that_is_closed_or_a_link_that_is_lost_gives_control_up() -> None:
    room = Room()
    room.take(ANA)
    room.wait(10 * ABSENT_S)
    assert room.lease.has(ANA)
    room.present.remove(ANA.session)
    room.wait(ABSENT_S)
    assert room.lease.has(ANA)
    room.wait(0.1)
    assert room.lease.holder is None
    room.take(BEN)


ACTS = st.sampled_from(["take", "release", "leave", "come"])
STEPS = st.one_of(
    st.tuples(ACTS, st.sampled_from([ANA, BEN, EVA])),
    st.tuples(st.just("wait"), st.floats(0.0, 50.0)),
    st.tuples(st.just("allow"), st.booleans()),
)


@given(st.lists(STEPS, max_size=40))
def test_nobody_loses_control_that_is_allowed_but_by_leaving(steps) -> None:  # type: ignore[no-untyped-def]
    room, was_open = Room(), True
    for what, argument in steps:
        before = room.lease.holder
        if what == "wait":
            room.wait(argument)
        elif what == "allow":
            room.allowed = argument
        elif what == "leave":
            room.present.discard(argument.session)
        elif what == "come":
            room.present.add(argument.session)
        elif what == "release":
            room.lease.release(argument)
        else:
            with contextlib.suppress(NotAllowedError):
                room.take(argument)
        room.wait(0.0)
        after = room.lease.holder
        changed = before is not None and (after is None or after.session != before.session)
        if changed and not was_open:
            is_own = what == "release" and argument.session == before.session
            assert is_own or before.session not in room.present
        # Allowed when it was taken, and since.
        was_open = after is None or not room.allowed or (was_open and after is before)
