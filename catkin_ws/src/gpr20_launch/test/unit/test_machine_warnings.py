"""Before a real robot starts, its computer is looked at; a simulated one needs nothing."""

import time

from case_kit import each_case

from gpr20_launch.mid.launch_request import REAL, ROBOT, SERVER, SIMULATED, SURVEY, LaunchRequest
from gpr20_launch.mid.machine_warnings import machine_warnings
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters

SECTIONS = {"x_axis": {}, "height_sensor": {"spi_device": 1}, "storage": {}}
ENVIRONMENT = {"ROS_IP": "127.0.0.1"}


def warnings(part, robot, root, sections=SECTIONS):
    request = LaunchRequest(part, robot, "", "", SimulatorParameters(scene=""))
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
