"""What the nodes say about themselves decides whether a robot is simulated."""

import pytest
from fake_robot import described_robot
from fault_kit import raises_fault
from survey_examples import AXES

from gpr20_common.mid.node_facts import Hardware
from gpr20_main_control.errors import CONFIGURATION_CHANGED, DeviceError
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import WRONG_VNA
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.plan.survey_state import SurveyState


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
