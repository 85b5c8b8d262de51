"""Who may move an axis."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from run_seed import draws

from gpr20_axis_driver.axis_exceptions import AxisBusyError, LeaseLapsedError
from gpr20_axis_driver.mid.axis_lease import AxisLease

LIMIT_S = 2.0


NAMES = st.sampled_from(["/main_control", "/rostopic_7", "/play_9"])


class LeaseMachine(RuleBasedStateMachine):
    """Random calls against a model: who holds it until when, and who moves."""

    def __init__(self):
        super().__init__()
        self.time_s = 100.0
        self.lease = AxisLease(LIMIT_S, lambda: self.time_s)
        self.holder, self.number, self.until_s = "", 0, 0.0
        self.uses = []  # names, exits and numbers of the motions under way
        self.numbers = [0]

    @property
    def owner(self):
        if self.uses:
            return self.uses[0][0]
        return self.holder if self.time_s <= self.until_s else ""

    @rule(passing_s=st.sampled_from([0.0, 0.5, 1.5, 2.5]))
    def time_passes(self, passing_s):
        self.time_s += passing_s

    @rule(name=NAMES)
    def somebody_reserves(self, name):
        if self.owner in ("", name):
            self.number = self.lease.reserve(name)
            assert self.number > max(self.numbers)
            self.numbers.append(self.number)
            self.holder, self.until_s = name, self.time_s + LIMIT_S
        else:
            with pytest.raises(AxisBusyError, match=self.owner):
                self.lease.reserve(name)

    @rule(name=NAMES, data=st.data())
    def somebody_renews(self, name, data):
        number = data.draw(st.sampled_from(self.numbers))
        if (name, number) == (self.holder, self.number) and self.time_s <= self.until_s:
            self.lease.renew(name, number)
            self.until_s = self.time_s + LIMIT_S
        else:
            with pytest.raises(LeaseLapsedError):
                self.lease.renew(name, number)

    @rule(name=NAMES, data=st.data())
    def somebody_releases(self, name, data):
        number = data.draw(st.sampled_from(self.numbers))
        self.lease.release(name, number)
        if (name, number) == (self.holder, self.number) and self.time_s <= self.until_s:
            self.holder = ""

    @rule(name=NAMES)
    def somebody_moves(self, name):
        use = self.lease.use(name)
        if self.owner not in ("", name):
            with pytest.raises(AxisBusyError, match=self.owner), use:
                raise AssertionError("refused")
            return
        held = self.holder == name and self.time_s <= self.until_s
        if self.holder == name and not held:
            with pytest.raises(LeaseLapsedError), use:
                raise AssertionError("nobody would watch this motion")
            return
        self.uses.append((name, use, use.__enter__(), self.number if held else 0))

    @precondition(lambda self: self.uses)
    @rule()
    def a_motion_ends(self):
        _name, use, _lapsed, _number = self.uses.pop()
        use.__exit__(None, None, None)

    @invariant()
    def there_is_one_owner_and_motions_end_exactly_with_their_lease(self):
        assert self.lease.owner == self.owner
        live = self.holder and self.time_s <= self.until_s
        for name, _use, lapsed, number in self.uses:
            held = live and (name, number) == (self.holder, self.number)
            assert lapsed() == (number > 0 and not held)


TestLeaseMachine = LeaseMachine.TestCase
TestLeaseMachine.settings = settings(max_examples=draws(25), stateful_step_count=30)
