"""What is looked at follows from the nodes, the two addresses and the computer."""

from pathlib import Path

import pytest

from gpr20_common.mid.node_facts import NO_HARDWARE, Hardware, NodeSoftware
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse
from gpr20_doctor.mid.machine_request import AUTOMATIC, REAL, SIMULATED, ThisMachine
from gpr20_survey.plan.robot_description import NodeDescription

# The doctor's own computer has one of these addresses and not the other.
HERE, THERE = "127.0.0.1", "192.0.2.1"


def nodes(host="pi", simulated=False, **axis):
    here = NodeSoftware("0.1.0", "", host)
    return {
        "x_axis/axis_driver": NodeDescription(
            "x_axis/axis_driver", Hardware("a driver", simulated), axis, here
        ),
        "vna_processing": NodeDescription("vna_processing", NO_HARDWARE, {"data": "/s"}, here),
        "vna_acquisition": NodeDescription(
            "vna_acquisition", Hardware("VNA", simulated), {"address": "10.0.0.9"}, here
        ),
    }


def machine(tmp_path, **environment):
    return ThisMachine("pi", {"GPR20_CONFIG": str(tmp_path / "config"), **environment}, tmp_path)


def test_everything_of_a_real_robot_on_one_computer_is_looked_at(tmp_path):
    request = machine(tmp_path).request(nodes(backend="pigpio"))
    assert request.hardware is HardwareUse.NEEDED
    assert not request.data_disk
    found = nodes()
    found["vna_processing"].configuration["data_disk"] = True
    assert machine(tmp_path).request(found).data_disk
    assert request.pin_library == "pigpio"
    assert machine(tmp_path).request(nodes()).pin_library == "rpi_gpio"
    assert (request.data, request.vna) == (Path("/s"), "10.0.0.9")


def test_only_axes_without_another_controller_need_pins(tmp_path):
    (tmp_path / "config").mkdir()
    other = "{controller: a.b:C}"
    for z_axis, library in (("{}", "rpi_gpio"), ("{backend: pigpio}", "pigpio"), (other, "")):
        text = f"x: {other}\ny: {other}\nz: {z_axis}\n"
        (tmp_path / "config/axes.yaml").write_text(text)
        request = machine(tmp_path).request({}, robot=REAL)
        assert (request.pin_library, request.pins) == (library, bool(library))
    found = nodes()
    own = NodeDescription("x_axis/axis_driver", Hardware("GRBL"), {"controller": "a.b:C"})
    found["x_axis/axis_driver"] = own
    assert not machine(tmp_path).request(found, robot=REAL).pins
    found["z_axis/axis_driver"] = nodes(backend="pigpio")["x_axis/axis_driver"]
    request = machine(tmp_path).request(found, robot=REAL)
    assert request.pins and request.pin_library == "pigpio"


@pytest.mark.parametrize(
    "running, robot, asked, expected",
    [
        ({}, AUTOMATIC, AUTOMATIC, REAL),
        ({}, SIMULATED, AUTOMATIC, SIMULATED),
        (nodes(simulated=True), AUTOMATIC, AUTOMATIC, SIMULATED),
        (nodes(simulated=True), AUTOMATIC, REAL, REAL),
        (nodes(), AUTOMATIC, "", ""),
    ],
)
def test_a_configuration_is_checked_as_that_of_the_robot_that_it_describes(
    tmp_path, running, robot, asked, expected
):
    request = machine(tmp_path).request(running, robot=robot, thorough=False, files=asked)
    assert request.files == expected


def test_only_a_folder_that_the_launch_was_given_is_named_as_given(tmp_path):
    (tmp_path / "config").mkdir()
    for text, given in (("data: /s\n", ""), ("data: /other\n", "/s")):
        (tmp_path / "config/storage.yaml").write_text(text)
        request = machine(tmp_path).request(nodes())
        assert (request.data, request.data_given) == (Path("/s"), given)


def test_nothing_of_a_simulated_robot_or_another_computer_is_looked_at(tmp_path):
    assert machine(tmp_path).request(nodes(), surveying=True).vna is None
    request = machine(tmp_path).request(nodes(host="other"))
    assert request.hardware is HardwareUse.ELSEWHERE
    assert (request.data, request.vna) == (None, None)
    request = machine(tmp_path).request(nodes(simulated=True))
    assert (request.hardware, request.vna) == (HardwareUse.SIMULATED, None)
    assert machine(tmp_path).request({}, robot=SIMULATED).hardware is HardwareUse.SIMULATED


def test_each_of_two_computers_has_its_part(tmp_path):
    robot = machine(tmp_path, GPR20_ROBOT=HERE, GPR20_SERVER=THERE).request({})
    assert (robot.hardware, robot.data, robot.vna) == (HardwareUse.NEEDED, None, None)
    server = machine(tmp_path, GPR20_ROBOT=THERE, GPR20_SERVER=HERE).request({})
    assert server.hardware is HardwareUse.ELSEWHERE
    assert server.data is not None and isinstance(server.vna, Unknown)


def test_without_nodes_the_computer_and_its_configuration_decide(tmp_path):
    assert machine(tmp_path).request({}).hardware is HardwareUse.NO_PI
    assert machine(tmp_path).request({}, robot=REAL).hardware is HardwareUse.NEEDED
    model = tmp_path / "proc/device-tree/model"
    model.parent.mkdir(parents=True)
    model.write_text("Raspberry Pi 4 Model B")
    (tmp_path / "config").mkdir()
    (tmp_path / "config/analyzer.yaml").write_text("address: 10.1.1.1\n")
    request = machine(tmp_path, GPR20_DATA="/data").request({})
    assert request.hardware is HardwareUse.NEEDED
    assert (request.vna, request.data) == ("10.1.1.1", Path("/data"))
    assert not request.data_disk
    (tmp_path / "config/storage.yaml").write_text("data_disk: true\n")
    assert machine(tmp_path).request({}).data_disk
    (tmp_path / "config/height.yaml").write_text("spi_device: 1\n")
    assert machine(tmp_path).request({}).spi == (0, 1)
    (tmp_path / "config/analyzer.yaml").write_text("address: GPIB0::16::INSTR\n")
    assert machine(tmp_path).request({}).vna is None
