"""What a launch may ask for, what it gives to its nodes, and what it warns of beforehand."""

import os
from pathlib import Path

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import CONFIGURATION, DISK_REFUSES, FILE_DAMAGED, NOT_ALLOWED
from gpr20_common.message import verbatim
from gpr20_common.mid.codec import record_from
from gpr20_launch import faults
from gpr20_launch.errors import LaunchRefusedError
from gpr20_launch.mid.launch_request import REAL, ROBOT, SERVER, SIMULATED, SURVEY, LaunchRequest
from gpr20_launch.mid.machine_warnings import machine_warnings
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_survey.faults import FOLDER_MOVED, NO_DATA_DISK, OTHER_DATA_FOLDER
from gpr20_survey.folder.data_folder import file_system_of, read_marker
from gpr20_vna_acquisition.mid.analyzer_record import Result, Status, store
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

PACKAGES = Path(__file__).resolve().parents[3]
AXES = PACKAGES / "gpr20_launch" / "config" / "axes.yaml"
SCENE = PACKAGES / "gpr20_simulator" / "scenes" / "two_targets.yaml"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GPR20_DATA", raising=False)
    return tmp_path


def request(part="survey", robot="simulated", config="", data="", **simulator):
    parameters = SimulatorParameters(**{"scene": str(SCENE), **simulator})
    return LaunchRequest(part, robot, config, data, parameters)


def test_each_part_starts_its_own_nodes():
    robot, server = set(request("robot").nodes), set(request("server").nodes)
    assert not robot & server
    assert robot | server == set(request().nodes)
    assert "simulator" in robot
    assert "simulator" not in request(robot="gpr20").nodes


def test_whether_the_window_covers_the_screen_is_auto_true_or_false():
    parameters = SimulatorParameters(scene=str(SCENE))
    for given in ("auto", "true", "false"):
        LaunchRequest("robot", "gpr20", "", "", parameters, given)
    with raises_fault(NOT_ALLOWED, "yes", "auto, true, false"):
        LaunchRequest("robot", "gpr20", "", "", parameters, "yes")


def test_the_default_configuration_is_read_from_the_home_folder(home):
    (home / ".gpr20" / "robot").mkdir(parents=True)
    (home / ".gpr20" / "robot" / "survey.yaml").write_text("settle_s: 2.5")
    assert request().sections(AXES)["survey"] == {"settle_s": 2.5}


def test_the_simulated_robot_has_its_own_devices_whatever_the_real_ones_are(home):
    config = home / "robot"
    config.mkdir()
    text = (
        "analyzer: other_package:Vna\nanalyzer_options: {port: 1}\naddress: GPIB0::16::INSTR\n"
        "maker: Agilent\nmodel: N5222A\naccepted_calibrations: [5]\nsettle_s: 1.5"
    )
    (config / "analyzer.yaml").write_text(text)
    (config / "axes.yaml").write_text("x: {controller: 'other:Axis', controller_options: {a: 1}}")
    sections = request(config=str(config)).sections(AXES)
    assert not {"controller", "controller_options"} & set(sections["x_axis"])
    simulated = sections["vna_acquisition"]
    parameters = record_from(VnaParameters, simulated, "vna_acquisition")
    default = VnaParameters()
    for name in ("analyzer", "maker", "model", "accepted_calibrations", "address"):
        assert getattr(parameters, name) == getattr(default, name)
    assert parameters.settle_s == 1.5
    real = request("robot", "gpr20", str(config)).sections(AXES)["vna_acquisition"]
    assert real["analyzer"] == "other_package:Vna" and real["address"] == "GPIB0::16::INSTR"


def test_the_rotation_of_the_real_robot_outlives_the_power(home):
    remembered = request(robot="gpr20").sections(AXES)["z_axis"]["memory_file"]
    assert remembered == str(home / ".gpr20" / "z_axis_steps")
    assert "memory_file" not in request().sections(AXES)["z_axis"]


def test_the_argument_comes_before_the_file_and_the_file_before_the_environment(home, monkeypatch):
    monkeypatch.setenv("GPR20_DATA", str(home / "environment"))
    assert request().sections(AXES)["storage"]["data"] == str(home / "environment")
    (home / "storage.yaml").write_text(f"data: {home}/file")
    config = str(home)
    assert request(config=config).sections(AXES)["storage"]["data"] == str(home / "file")
    # Relative paths are those of the terminal.
    monkeypatch.chdir(home)
    (home / "my").mkdir()
    (home / "my/scene.yaml").write_text("name: mine")
    given = request(config=config, data="my surveys", scene="my/scene.yaml").sections(AXES)
    assert given["storage"]["data"] == str(home / "my surveys")
    assert given["simulator"]["scene"] == str(home / "my/scene.yaml")


@each_case(
    "arguments, fault, shown",
    [
        ({"robot": "gpr21"}, NOT_ALLOWED, "gpr21"),
        ({"robot": "gpr20", "time_scale": 2.0}, NOT_ALLOWED, ":=2"),
        ({"config": str(SCENE)}, CONFIGURATION, SCENE),
        ({"config": "/nowhere"}, CONFIGURATION, "/nowhere"),
        ({"scene": "/nowhere.yaml"}, NOT_ALLOWED, "/nowhere.yaml"),
        ({"time_scale": 0.0}, NOT_ALLOWED, "time_scale"),
        ({"seconds_per_point": -1.0}, NOT_ALLOWED, "-1 s"),
    ],
)
def test_what_cannot_be_launched_is_refused(arguments, fault, shown):
    with raises_fault(fault, shown):
        request(**arguments).sections(AXES)


def test_a_data_folder_that_cannot_be_written_is_refused_where_it_is_needed(home):
    (home / "a file").write_text("")
    read_only = home / "read only"
    read_only.mkdir(mode=0o500)
    for folder in (home / "a file", Path("/proc/surveys") if os.geteuid() == 0 else read_only):
        refusals = (FILE_DAMAGED, DISK_REFUSES, FOLDER_MOVED)
        with raises_fault(refusals, folder, error=LaunchRefusedError):
            request(data=str(folder)).sections(AXES)
        assert "data" not in request("robot", data=str(folder)).sections(AXES)["storage"]


def test_a_launch_marks_the_data_folder_and_never_makes_one_in_its_place(home):
    folder = home / "surveys"
    for _launch in range(2):
        request(data=str(folder)).sections(AXES)
    assert read_marker(folder) is not None
    folder.rename(home / "moved")
    with raises_fault(OTHER_DATA_FOLDER, folder, error=LaunchRefusedError):
        request(data=str(folder)).sections(AXES)
    assert not folder.exists()
    (home / "moved").rename(folder)
    assert request(data=str(folder)).sections(AXES)["storage"]["data"] == str(folder)


def test_a_data_disk_that_is_not_there_refuses_the_launch(home):
    if file_system_of(home).device != file_system_of(Path("/")).device:
        pytest.skip("the temporary folder is not on the disk of the system")
    (home / "storage.yaml").write_text("data_disk: true")
    with raises_fault(NO_DATA_DISK, home / "surveys", error=LaunchRefusedError):
        request(config=str(home), data=f"{home}/surveys").sections(AXES)
    assert not (home / "surveys").exists()


SECTIONS = {"x_axis": {}, "height_sensor": {"spi_device": 1}, "storage": {}}
ENVIRONMENT = {"ROS_IP": "127.0.0.1"}


def warnings(part, robot, root, sections=SECTIONS, config=""):
    request = LaunchRequest(part, robot, config, "", SimulatorParameters(scene=""))
    return machine_warnings(request, sections, ENVIRONMENT, root)


@each_case("part, needed", [(ROBOT, True), (SURVEY, True), (SERVER, False)])
def test_a_real_robot_without_its_bus_is_warned_and_a_simulated_one_needs_none(
    tmp_path, part, needed
):
    texts = [str(one.text) for one in warnings(part, REAL, tmp_path)]
    assert any("/dev/spidev0.1" in text for text in texts) is needed
    assert warnings(part, SIMULATED, tmp_path) == ()


def test_axes_of_other_controllers_need_no_pins(tmp_path):
    other = {"controller": "a.b:C"}
    axes = {"x_axis": other, "y_axis": other, "z_axis": other}
    some = warnings(ROBOT, REAL, tmp_path, {**SECTIONS, **axes, "z_axis": {}})
    assert "gpio" in [one.check for one in some]
    none = warnings(ROBOT, REAL, tmp_path, {**SECTIONS, **axes})
    assert not {"gpio", "realtime"} & {one.check for one in none}


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

    code = faults.NOT_CHECKED.as_warning().code
    assert code in codes() and code in codes(part=SERVER)
    assert code not in codes(part=ROBOT) + codes(robot=SIMULATED) + codes(analyzer={})
    for status in (Status.FAILED, Status.PASSED):
        assert code in codes()
        found = [Result("identity", status, verbatim("found"))]
        store(tmp_path, VnaParameters(**own), found)
    assert code not in codes()
