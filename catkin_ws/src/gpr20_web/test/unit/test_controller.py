"""One browser at a time is in control, and none takes it out of sight of the other."""

from __future__ import annotations

from typing import Set

import pytest
from hypothesis import given
from hypothesis import strategies as st
from web_kit import ManualClock

from gpr20_common.faults import BUSY
from gpr20_web.calls import Call, Person, Role
from gpr20_web.errors import BadRequestError, NotAllowedError, NotNowError
from gpr20_web.mid.controller import ABSENT_S, ANSWER_S, Controller, ControlPage

ANA, BEN, EVA = (Person(name, Role.CONTROL, f"session of {name}", "") for name in "abe")


class Room:
    def __init__(self) -> None:
        self.time = ManualClock()
        self.present: Set[str] = {ANA.session, BEN.session, EVA.session}
        self.controller = Controller(self.time, lambda session: session in self.present)

    def wait(self, time_s: float) -> None:
        self.time.time_s += time_s
        self.controller.refresh()


def test_first_who_takes_control_has_it_until_its_person_passes_it_on() -> None:
    room = Room()
    room.controller.take(ANA)
    room.controller.check(ANA)
    twin = Person(ANA.name, ANA.role, "other session", "")
    for other in (BEN, twin):
        with pytest.raises(NotAllowedError, match="another page is in control: a"):
            room.controller.check(other)
    room.controller.take(BEN)
    with pytest.raises(NotAllowedError, match="b asks for control already") as refusal:
        room.controller.take(EVA)
    assert refusal.value.message.fault == BUSY
    assert room.controller.has(ANA)
    room.controller.give(ANA, BEN.mark)
    assert room.controller.has(BEN) and room.controller.asked is None


def test_control_passes_only_to_whom_its_person_has_seen_asking() -> None:
    room = Room()
    room.controller.take(ANA)
    room.controller.take(BEN)
    room.controller.release(BEN)
    with pytest.raises(NotNowError, match="does not ask for it now"):
        room.controller.give(ANA, BEN.mark)
    room.controller.take(EVA)
    with pytest.raises(NotNowError):
        room.controller.give(ANA, BEN.mark)
    assert room.controller.has(ANA) and room.controller.asked is not None
    page = ControlPage(room.controller, room.time)
    steps = {one.pattern: one.answer for one in page.routes}
    with pytest.raises(BadRequestError, match="mark"):
        steps["/api/control/pass"](Call(ANA))
    steps["/api/control/pass"](Call(ANA, values={"mark": EVA.mark}))
    assert room.controller.has(EVA)


def test_request_passes_after_it_was_seen_long_enough_and_nobody_answered() -> None:
    room = Room()
    room.controller.take(ANA)
    room.controller.take(BEN)
    room.controller.keep(ANA)
    room.wait(10 * ANSWER_S)
    assert room.controller.has(ANA)
    room.controller.take(EVA)
    # A browser that left asks no more.
    room.present.remove(EVA.session)
    room.wait(ANSWER_S + 1.0)
    assert room.controller.has(ANA)
    room.controller.take(BEN)
    room.wait(ANSWER_S - 1.0)
    assert room.controller.has(ANA)
    room.wait(1.0)
    assert room.controller.has(BEN)
    # One that is in control loses it to nobody.
    room.present.remove(BEN.session)
    room.wait(ABSENT_S)
    assert room.controller.has(BEN)
    room.wait(0.1)
    assert room.controller.holder is None


ACTS = st.sampled_from(["take", "release", "pass", "keep", "leave", "come"])
STEPS = st.one_of(
    st.tuples(ACTS, st.sampled_from([ANA, BEN, EVA])),
    st.tuples(st.just("wait"), st.floats(0.0, 50.0)),
)


@given(st.lists(STEPS, max_size=40))
def test_control_changes_hands_only_by_its_person_or_after_a_seen_request(steps) -> None:  # type: ignore[no-untyped-def]
    room = Room()
    controller, asked_s = room.controller, {}
    for what, argument in steps:
        before = controller.holder
        was_asked = controller.asked
        try:
            if what == "wait":
                room.wait(argument)
            elif what == "leave":
                room.present.discard(argument.session)
            elif what == "come":
                room.present.add(argument.session)
            elif what == "pass":
                controller.give(argument, was_asked.person.mark if was_asked else "")
            else:
                getattr(controller, what)(argument)
        except (NotAllowedError, NotNowError):
            pass
        after = controller.holder
        if controller.asked is not None and controller.asked is not was_asked:
            asked_s[controller.asked.person.session] = room.time.time_s
        if before is None or after is None or before.session == after.session:
            continue
        by_person = what in ("pass", "release") and argument.session == before.session
        waited_s = room.time.time_s - asked_s[after.session]
        assert by_person or waited_s >= min(ANSWER_S, ABSENT_S)
