"""The lease of an axis: when it is renewed, released and replaced."""

import pytest
from fake_robot import FakeAxis

from gpr20_common.message import verbatim
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.axis_motion import LeaseKeeper
from gpr20_main_control.mid.devices.robot import Lease


class ScriptedAxis(FakeAxis):
    """An axis that renews a lease so many times, and notes what was asked."""

    def __init__(self, renewals):
        super().__init__()
        self.renewals, self.asked = renewals, []

    def lease(self, number=0, release=False):
        self.asked.append("release" if release else "renew")
        if not release and self.asked.count("renew") > self.renewals:
            raise DeviceError(verbatim("the lease has ended"))


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
    "lacks, renewals, asked",
    [
        ((False, False), 2, ["renew", "renew", "release"]),
        # Nobody looks at what could stop the axis.
        ((False, True, True, False), 2, ["renew", "renew", "release"]),
        ((False, False), 0, ["renew"]),
    ],
)
def test_a_lease_is_renewed_while_it_lives_and_somebody_looks(lacks, renewals, asked):
    axis, script = ScriptedAxis(renewals), Scripted(*lacks)
    LeaseKeeper(axis, script)._keep(Lease(1, 2.0), script)
    assert axis.asked == asked
