"""The lease of an axis: when it is renewed, released and replaced."""

import pytest
from fake_robot import FakeAxis

from gpr20_main_control.mid.devices.axis_motion import LeaseKeeper
from gpr20_main_control.mid.devices.robot import Lease


class ScriptedAxis(FakeAxis):
    """An axis that answers requests to renew a lease as a test says, and notes all requests."""

    def __init__(self, *answers):
        super().__init__()
        self.answers, self.asked = list(answers), []

    def renew(self, _lease):
        self.asked.append("renew")
        return self.answers.pop(0)

    def release_lease(self, _lease):
        self.asked.append("release")


class Scripted:
    """The attention of the thread that moves axes, turn by turn, and the end after the last."""

    def __init__(self, *lacks):
        self.turns = list(lacks)

    @property
    def lacks(self):
        return self.turns.pop(0)

    def wait(self, _timeout_s):
        return not self.turns


@pytest.mark.parametrize(
    "lacks, answers, asked",
    [
        ((False, False), (True, True), ["renew", "renew", "release"]),
        # Nobody looks at what could stop the axis.
        ((False, True, True, False), (True, True), ["renew", "renew", "release"]),
        ((False, False), (False,), ["renew"]),
    ],
)
def test_a_lease_is_renewed_while_it_lives_and_somebody_looks(lacks, answers, asked):
    axis, script = ScriptedAxis(*answers), Scripted(*lacks)
    LeaseKeeper(axis, script)._keep(Lease(1, 2.0), script)
    assert axis.asked == asked
