"""The axes together: their leases, and what becomes of the others when one fails."""

import pytest
from fake_robot import FakeAxis, FastClock

from gpr20_common.message import verbatim
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid import waits
from gpr20_main_control.mid.devices.positioner import LeaseKeeper
from gpr20_main_control.mid.devices.robot import Lease
from gpr20_main_control.mid.waits import Interruption


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
    """Whether the thread that moves axes looks, turn by turn, and the end after the last."""

    def __init__(self, *neglected):
        self.turns = list(neglected)

    @property
    def is_neglected(self):
        return self.turns.pop(0)

    def wait(self, _timeout_s):
        return not self.turns


@pytest.mark.parametrize(
    "neglected, renewals, asked",
    [
        ((False, False), 2, ["renew", "renew", "release"]),
        # Nobody looks at what could stop the axis.
        ((False, True, True, False), 2, ["renew", "renew", "release"]),
        ((False, False), 0, ["renew"]),
    ],
)
def test_a_lease_is_renewed_while_it_lives_and_somebody_looks(neglected, renewals, asked):
    axis, script = ScriptedAxis(renewals), Scripted(*neglected)
    LeaseKeeper(axis, script)._keep(Lease(1, 2.0), script)
    assert axis.asked == asked


def test_only_axes_that_move_need_somebody_who_looks(monkeypatch):
    interruption = Interruption(FastClock())
    monkeypatch.setattr(waits, "ATTENTION_S", -1.0)
    assert not interruption.is_neglected
    with interruption.moving():
        assert interruption.is_neglected
        monkeypatch.setattr(waits, "ATTENTION_S", 3600.0)
        interruption.check()
        assert not interruption.is_neglected
