"""What a launch may ask for, what it gives to its nodes, and what it warns of beforehand."""

import os
from pathlib import Path

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import DISK_REFUSES, FILE_DAMAGED
from gpr20_common.mid.codec import record_from
from gpr20_launch.faults import LaunchRefusedError
from gpr20_launch.mid.launch_request import nodes_of, sections_of
from gpr20_launch.mid.robot_files import Reading, Use
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_survey.faults import FOLDER_MOVED, OTHER_DATA_FOLDER
from gpr20_survey.folder.data_folder import read_marker
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

PACKAGES = Path(__file__).resolve().parents[3]
AXES = PACKAGES / "gpr20_launch" / "config" / "axes.yaml"
SCENE = PACKAGES / "gpr20_simulator" / "scenes" / "two_targets.yaml"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GPR20_DATA", raising=False)
    return tmp_path


def sections(part="survey", robot="simulated", config="", data="", **simulator):
    """Return what the nodes of a launch get."""
    folder = config or Path.home() / ".gpr20/robot"
    parameters = SimulatorParameters(**{"scene": str(SCENE), **simulator})
    use = Use({}, data, robot == "gpr20", part)
    return sections_of(Reading(Path(folder), AXES), use, parameters)


def test_each_part_starts_its_own_nodes():
    def nodes(part, real=False):
        return set(nodes_of(Use({}, real=real, part=part)))

    assert not nodes("robot") & nodes("server")
    assert nodes("robot") | nodes("server") == nodes("survey")
    assert nodes("robot") - nodes("robot", real=True) == {"simulator"}


def test_the_simulated_robot_has_its_own_devices_whatever_the_real_ones_are(home):
    config = home / "robot"
    config.mkdir()
    text = (
        "analyzer: other_package:Vna\nanalyzer_options: {port: 1}\naddress: GPIB0::16::INSTR\n"
        "maker: Agilent\nmodel: N5222A\naccepted_calibrations: [5]\nsettle_s: 1.5"
    )
    (config / "analyzer.yaml").write_text(text)
    (config / "axes.yaml").write_text("x: {controller: 'other:Axis', controller_options: {a: 1}}")
    found = sections(config=str(config))
    assert not {"controller", "controller_options"} & set(found["x_axis"])
    simulated = found["vna_acquisition"]
    parameters = record_from(VnaParameters, simulated, "vna_acquisition")
    default = VnaParameters()
    for name in ("analyzer", "maker", "model", "accepted_calibrations", "address"):
        assert getattr(parameters, name) == getattr(default, name)
    assert parameters.settle_s == 1.5
    real = sections("robot", "gpr20", str(config))["vna_acquisition"]
    assert real["analyzer"] == "other_package:Vna" and real["address"] == "GPIB0::16::INSTR"


def test_the_rotation_of_the_real_robot_outlives_the_power(home):
    remembered = sections(robot="gpr20")["z_axis"]["memory_file"]
    assert remembered == str(home / ".gpr20" / "z_axis_steps")
    assert "memory_file" not in sections()["z_axis"]


def test_the_argument_comes_before_the_file_and_the_file_before_the_environment(home, monkeypatch):
    monkeypatch.setenv("GPR20_DATA", str(home / "environment"))
    assert sections()["storage"]["data"] == str(home / "environment")
    (home / "storage.yaml").write_text(f"data: {home}/file")
    config = str(home)
    assert sections(config=config)["storage"]["data"] == str(home / "file")
    # Relative paths are those of the terminal.
    monkeypatch.chdir(home)
    (home / "my").mkdir()
    (home / "my/scene.yaml").write_text("name: mine")
    given = sections(config=config, data="my surveys", scene="my/scene.yaml")
    assert given["storage"]["data"] == str(home / "my surveys")
    assert given["simulator"]["scene"] == str(home / "my/scene.yaml")


@each_case(
    "arguments, shown",
    [
        (["--robot", "gpr21"], "gpr21"),
        (["--full_screen", "yes"], "yes"),
        (["--time_scale", "fast"], "fast"),
        (["--robot", "gpr20", "--time_scale", "2"], ":=2"),
        (["--config", SCENE], SCENE),
        (["--config", "/nowhere"], "/nowhere"),
        (["--scene", "/nowhere.yaml"], "/nowhere.yaml"),
        (["--time_scale", "0"], "time_scale"),
        (["--seconds_per_point", "-1.0"], "-1 s"),
    ],
)
def test_what_cannot_be_launched_is_refused(run, capfd, arguments, shown):
    try:
        given = ("--part", "robot", "--robot", "simulated", "--scene", SCENE, *arguments)
        status, printed, said = run("check_launch", *given)
    except SystemExit as error:
        status, (printed, said) = error.code, capfd.readouterr()
    assert status != 0 and not printed and str(shown) in said


def test_a_data_folder_that_cannot_be_written_is_refused_where_it_is_needed(home):
    (home / "a file").write_text("")
    read_only = home / "read only"
    read_only.mkdir(mode=0o500)
    for folder in (home / "a file", Path("/proc/surveys") if os.geteuid() == 0 else read_only):
        refusals = (FILE_DAMAGED, DISK_REFUSES, FOLDER_MOVED)
        with raises_fault(refusals, folder, error=LaunchRefusedError):
            sections(data=str(folder))
        assert "data" not in sections("robot", data=str(folder))["storage"]


def test_a_launch_marks_the_data_folder_and_never_makes_one_in_its_place(home):
    folder = home / "surveys"
    for _launch in range(2):
        sections(data=str(folder))
    assert read_marker(folder) is not None
    folder.rename(home / "moved")
    with raises_fault(OTHER_DATA_FOLDER, folder, error=LaunchRefusedError):
        sections(data=str(folder))
    assert not folder.exists()
    (home / "moved").rename(folder)
    assert sections(data=str(folder))["storage"]["data"] == str(folder)
