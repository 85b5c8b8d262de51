"""Before a real robot starts, its computer is looked at; a simulated one needs nothing."""

import time

from case_kit import each_case

from gpr20_common.message import verbatim
from gpr20_launch import faults
from gpr20_launch.mid.launch_request import REAL, ROBOT, SERVER, SIMULATED, SURVEY, LaunchRequest
from gpr20_launch.mid.machine_warnings import machine_warnings
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_vna_acquisition.mid.conformance.bench import Status
from gpr20_vna_acquisition.mid.conformance.record import store
from gpr20_vna_acquisition.mid.conformance.suite import Result
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SECTIONS = {"x_axis": {}, "height_sensor": {"spi_device": 1}, "storage": {}}
ENVIRONMENT = {"ROS_IP": "127.0.0.1"}


def warnings(part, robot, root, sections=SECTIONS, config=""):
    request = LaunchRequest(part, robot, config, "", SimulatorParameters(scene=""))
    return machine_warnings(request, sections, ENVIRONMENT, root)


def test_a_simulated_robot_needs_no_hardware(tmp_path):
    assert warnings(SURVEY, SIMULATED, tmp_path) == ()


@each_case("part", [ROBOT, SURVEY])
def test_a_real_robot_without_its_bus_is_warned_at_once(tmp_path, part):
    begun_s = time.thread_time()
    texts = [str(one.text) for one in warnings(part, REAL, tmp_path)]
    assert time.thread_time() - begun_s < 0.3
    assert any("/dev/spidev0.1" in text for text in texts)


def test_axes_of_other_controllers_need_no_pins(tmp_path):
    other = {"controller": "a.b:C"}
    axes = {"x_axis": other, "y_axis": other, "z_axis": other}
    some = warnings(ROBOT, REAL, tmp_path, {**SECTIONS, **axes, "z_axis": {}})
    assert "gpio" in [one.check for one in some]
    none = warnings(ROBOT, REAL, tmp_path, {**SECTIONS, **axes})
    assert not {"gpio", "realtime"} & {one.check for one in none}


def test_the_server_needs_no_bus(tmp_path):
    assert not any("spidev" in str(one.text) for one in warnings(SERVER, REAL, tmp_path))


class OwnAnalyzer:
    """A class for another analyzer."""

    connect = identify = check_sweep = configure = sweep = confirm = calibration = None
    release = disconnect = trace_duration_s = remarks = None

    def __init__(self, parameters, deadline):
        raise AssertionError("it is not made")


def test_a_class_for_the_analyzer_that_never_passed_its_check_is_warned_of(tmp_path):
    own = {"analyzer": f"{__name__}:OwnAnalyzer"}

    def codes(part=SURVEY, robot=REAL, analyzer=own):
        sections = {**SECTIONS, "vna_acquisition": analyzer}
        found = warnings(part, robot, tmp_path, sections, str(tmp_path))
        return [one.text.fault_code for one in found]

    code = faults.UNCHECKED_ANALYZER.code
    assert code in codes() and code in codes(part=SERVER)
    assert code not in codes(part=ROBOT) + codes(robot=SIMULATED) + codes(analyzer={})
    for status in (Status.FAILED, Status.PASSED):
        assert code in codes()
        found = [Result("identity", status, verbatim("found"))]
        store(tmp_path, VnaParameters(**own), found)
    assert code not in codes()
