"""Parts of the robot: leases of the axes, nodes that are missing, what the nodes say they are."""

import pytest
from fake_robot import FakeAxis, FastClock, ManualClock, described_robot
from fault_kit import raises_fault
from survey_examples import AXES

from gpr20_common.faults import PART_SILENT
from gpr20_common.message import verbatim
from gpr20_common.mid.node_facts import Hardware
from gpr20_main_control.errors import CONFIGURATION_CHANGED, DeviceError, NodeLostError
from gpr20_main_control.mid import waits
from gpr20_main_control.mid.devices.node_liveness import START_LIMIT_S, NodeLiveness
from gpr20_main_control.mid.devices.positioner import LeaseKeeper
from gpr20_main_control.mid.devices.robot import Lease
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import WRONG_VNA
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.plan.survey_state import SurveyState


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


class Watched:
    """Two nodes that a test notes, and the messages about those that were missing."""

    def __init__(self):
        self.clock = ManualClock()
        self.reported = []
        self.nodes = NodeLiveness(self.clock, self._note)
        for name in ("x", "y"):
            self.nodes.watch(name, verbatim(name), None)

    def _note(self, message):
        self.reported.append(message and message.all_details)
        assert message is None or message.fault_code == PART_SILENT.code

    def all_alive(self):
        self.nodes.note("x", 1)
        self.nodes.note("y", 2)
        return self.nodes


def test_a_node_is_called_missing_at_once_if_it_was_there_and_otherwise_when_it_had_its_time():
    bench = Watched()
    bench.nodes.note("x", None)
    assert bench.reported == []
    bench.clock.time_s += START_LIMIT_S + 1.0
    bench.nodes.note("x", None)
    assert bench.reported == [("x", "y")]
    nodes = bench.all_alive()
    nodes.note("y", None)
    nodes.note("y", None)
    nodes.note("y", 3)
    assert bench.reported == [("x", "y"), ("y",), None, ("y",), None]


def test_a_node_that_was_restarted_is_lost_until_it_is_accepted():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.check()
    nodes.note("x", 17)
    with raises_fault(PART_SILENT, "(x)", error=NodeLostError):
        nodes.check()
    nodes.note("y", None)
    assert nodes.lost().all_details == ("y", "x")
    nodes.note("y", 2)
    nodes.accept()
    nodes.check()


def redescribe(robot, node, simulated=True, **changes):
    before = robot.nodes[node]
    hardware = Hardware("another", simulated)
    robot.note(NodeDescription(node, hardware, {**before.configuration, **changes}))


@pytest.mark.parametrize(
    "identity, simulated",
    [("Anritsu,MS2026C/2,SIMULATED,1.0", False), ("Anritsu,MS2026C/2,1234567,1.0", True)],
)
def test_an_instrument_of_the_other_kind_is_refused(identity, simulated):
    robot = described_robot(simulated=simulated)
    with raises_fault(WRONG_VNA, identity, error=DeviceError):
        robot.check_identity(identity, robot.config())


def test_a_survey_pauses_when_a_node_comes_back_as_another_one(bench):
    bench.at_sweep(3, lambda: redescribe(bench.description, "y_axis/axis_driver", max_coord=700.0))
    bench.start()
    status = bench.wait_for(SurveyState.PAUSED)
    assert status.message.fault_code == CONFIGURATION_CHANGED.code
    redescribe(bench.description, "y_axis/axis_driver", max_coord=AXES[AxisId.Y].max_coord)
    bench.resume_to_the_end()
