"""The check of the whole robot: one function, and what command, launch and programs get of it."""

import json
import sys
from pathlib import Path

import pytest
from case_kit import each_case
from robot_check_examples import BUILT, PROFILES, VNA, checked, write

from gpr20_common.sent_message import received_message
from gpr20_launch import faults
from gpr20_launch.mid import place_checks
from gpr20_launch.mid.axis_checks import DescriptionError, read_frame
from gpr20_launch.mid.pin_table import BOARD_OF_GPIO, GPIO_OF_BOARD, NOT_GPIO, SPI_BUSES
from gpr20_launch.mid.robot_check import BuiltRobot, check_robot
from gpr20_launch.mid.wiring import TASKS, WITH_ROBOT, Unchecked

REFUSED, DOUBTFUL = True, False
SENSOR = "topic: soil/values, message: std_msgs/Float64, field: data"
LEFT = ("axes.yaml.bak", "axes.yaml~", ".axes.yaml.swp", "axes.yaml.dpkg-old", "#axes.yaml#")
PACKAGED = ("axes.yaml.dpkg-new", "axes.yaml.dpkg-dist", "axes.yaml.2", "axes.yml.orig")
# File and text, then file, key, fault and whether it refuses, then words of the sentence.
# test_mistakes_of_technicians.py has more; here each fault of the check is there.
MISTAKES = [
    # Pins, with everything that uses them.
    (
        *("axes", "y: {sensor_pin: 11}"),
        *("axes.yaml", "z/dir_pin", faults.PIN_CONFLICT, REFUSED),
        ("pin 11", "GPIO17", "axes.yaml y/sensor_pin", "axes.yaml z/dir_pin (default)"),
    ),
    (
        *("axes", "x: {dir_pin: 33}\ny: {dir_pin: 33}\nz: {step_pin: 33}"),
        *("axes.yaml", "z/step_pin", faults.PIN_CONFLICT, REFUSED),
        ("3 purposes", "x/dir_pin", "y/dir_pin", "z/step_pin", "enable_pin"),
    ),
    (
        *("axes", "x: {sensor_pin: 19}"),
        *("height.yaml", "spi_bus", faults.PIN_CONFLICT, REFUSED),
        ("x/sensor_pin", "height.yaml spi_bus: SPI0 MOSI"),
    ),
    (
        *("height", "spi_bus: 5\nspi_device: 1"),
        *("height.yaml", "spi_device", faults.PIN_CONFLICT, REFUSED),
        ("y/dir_pin (default)", "SPI5 CE1"),
    ),
    (
        *("axes", "x: {enable_pin: 26}"),
        *("axes.yaml", "x/enable_pin", faults.PIN_UNUSABLE, DOUBTFUL),
        ("CE1",),
    ),
    (
        *("axes", "x: {dir_pin: 28}"),
        *("axes.yaml", "x/dir_pin", faults.PIN_UNUSABLE, REFUSED),
        ("EEPROM", "29, 31"),
    ),
    (
        *("axes", "x: {step_pin: 8}"),
        *("axes.yaml", "x/step_pin", faults.PIN_UNUSABLE, DOUBTFUL),
        ("console",),
    ),
    (
        *("axes", "x: {dir_pin: 3}"),
        *("axes.yaml", "x/dir_pin", faults.PIN_UNUSABLE, DOUBTFUL),
        ("1.8 kOhm",),
    ),
    (
        *("axes", "x: {dir_pin: 14}"),
        *("axes.yaml", "x/dir_pin", faults.WRONG_VALUE, REFUSED),
        ("pin 14 is ground", "BOARD"),
    ),
    # Travel, motion, endstops.
    (
        *("axes", "y: {max_coord: 80000}"),
        *("axes.yaml", "y/max_coord", faults.TRAVEL, REFUSED),
        ("80000 mm", "20 to 3000 mm"),
    ),
    (
        *("axes", "y: {max_coord: 880}"),
        *("axes.yaml", "y/max_coord", faults.TRAVEL, DOUBTFUL),
        ("880 mm", "URDF", "0 - 800 mm"),
    ),
    (
        *("axes", "x: {max_coord: 1200}"),
        *("axes.yaml", "x/max_coord", faults.TRAVEL, DOUBTFUL),
        ("frame", "880 mm"),
    ),
    (
        *("axes", "z: {max_coord: 45}"),
        *("axes.yaml", "z/max_coord", faults.TRAVEL, DOUBTFUL),
        ("0 and 90",),
    ),
    (
        *("axes", "x: {step_size: 0.001}"),
        *("axes.yaml", "x/step_size", faults.MOTION, REFUSED),
        ("1.8 hours",),
    ),
    (
        *("axes", "x: {step_size: 0.00001}"),
        *("axes.yaml", "x/step_size", faults.MOTION, REFUSED),
        ("1e-05 mm", "0.0005 - 1 mm"),
    ),
    (
        *("axes", "x: {homing_margin: 640}"),
        *("axes.yaml", "x/homing_margin", faults.MOTION, REFUSED),
        ("640 mm", "<= 50 mm"),
    ),
    (
        *("axes", "z: {min_coord: 0, max_coord: 270}"),
        *("axes.yaml", "z/max_coord", faults.TRAVEL, REFUSED),
        ("270 deg", "cables"),
    ),
    (
        *("axes", "x: {min_step: 0.0004, max_step: 0.0004, late_limit_s: 0.0003}"),
        *("axes.yaml", "x/max_step", faults.MOTION, DOUBTFUL),
        ("1250 steps per second",),
    ),
    (
        *("axes", "z: {min_step: 0.0009, delta_step: 0.02}"),
        *("axes.yaml", "z/delta_step", faults.MOTION, DOUBTFUL),
        ("deg/s",),
    ),
    (
        *("axes", "x: {sensor_pin: 5, endstop_pull: none}"),
        *("axes.yaml", "x/endstop_pull", faults.ENDSTOP, REFUSED),
        ("1.8 kOhm", "up"),
    ),
    # Typing.
    (
        *("axes", "x: {step_size: 0,01}"),
        *("axes.yaml", "x/step_size", faults.WRONG_VALUE, REFUSED),
        ("'0,01'", "write a point, not a comma: 0.01"),
    ),
    (
        *("height", "Spi_Bus: 0"),
        *("height.yaml", "Spi_Bus", faults.WRONG_VALUE, REFUSED),
        ("perhaps spi_bus",),
    ),
    # Data, addresses, sensors, site, wiring.
    (
        *("storage", "data: surveys"),
        *("storage.yaml", "data", faults.DATA_FOLDER, REFUSED),
        ("surveys", "/srv/gpr20/surveys"),
    ),
    (
        *("storage", "data: ~/no_such_disk/surveys"),
        *("storage.yaml", "data", faults.DATA_FOLDER, DOUBTFUL),
        ("does not exist",),
    ),
    (
        *("storage", "disk_reserve_mb: 900000000"),
        *("storage.yaml", "disk_reserve_mb", faults.DATA_FOLDER, DOUBTFUL),
        ("no survey can start",),
    ),
    (
        *("storage", "signing_key: /nowhere/key"),
        *("storage.yaml", "signing_key", None, DOUBTFUL),
        ("/nowhere/key", "not signed"),
    ),
    (
        *("analyzer", "address: 127.0.0.1"),
        *("analyzer.yaml", "address", faults.ADDRESS, DOUBTFUL),
        ("127.0.0.1",),
    ),
    (
        *("analyzer", "address: 224.0.0.1"),
        *("analyzer.yaml", "address", faults.ADDRESS, REFUSED),
        ("224.0.0.1",),
    ),
    (
        *("height", "reference_voltage_v: 5.0"),
        *("height.yaml", "reference_voltage_v", faults.INPUT_VOLTAGE, DOUBTFUL),
        ("5 V", "MISO"),
    ),
    (
        *("sensors", f"sensors: [{{name: a, {SENSOR}}}, {{name: b, {SENSOR}}}]"),
        *("sensors.yaml", "sensors[1]/field", faults.SENSORS, DOUBTFUL),
        ("sensor a",),
    ),
    (
        *("site", "latitude_deg: 0.0\nlongitude_deg: 0.0"),
        *("site.yaml", "latitude_deg", faults.SITE, DOUBTFUL),
        ("sea",),
    ),
    (
        *("wiring", "unchecked: [pins]"),
        *("wiring.yaml", "unchecked", faults.NOT_CHECKED, REFUSED),
        ("pins", "continuity meter"),
    ),
    # Files.
    ("axes_2", "", "axes_2.yaml", "", faults.UNKNOWN_FILE, REFUSED, ("axes.yaml, ",)),
    *(
        (name, "x: 5", name, "", faults.LEFT_OVER_FILE, DOUBTFUL, ("is not read",))
        for name in (*LEFT, *PACKAGED)
    ),
]
BOTH = {"GPR20_ROBOT": "192.168.1.2", "GPR20_SERVER": "192.168.1.3"}


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))
    monkeypatch.setenv("GPR20_ENVIRONMENT", str(tmp_path / "none"))
    monkeypatch.delenv("GPR20_DATA", raising=False)
    monkeypatch.setattr(place_checks, "free_bytes", lambda _folder: 5e10)
    (tmp_path / "home/surveys").mkdir(parents=True)


@pytest.fixture
def run(monkeypatch, capfd):
    """Return a function that runs a program and returns its status and what it printed."""

    def run(module, *arguments):
        main = pytest.importorskip(f"gpr20_launch.high.{module}").main
        monkeypatch.setattr(sys, "argv", [module, *map(str, arguments)])
        return (main(), *capfd.readouterr())

    return run


@each_case("mistake", MISTAKES)
def test_a_mistake_is_found_everywhere_with_file_key_value_and_uses(tmp_path, run, mistake):
    name, text, file, key, fault, refused, shown = mistake
    folder = tmp_path / str(MISTAKES.index(mistake))
    write(folder, {name: text})
    (one,) = checked(folder)
    text = str(one.message)
    assert (Path(one.file).name, one.key, one.refuses) == (file, key, refused), text
    assert one.file in text and all(word in text for word in shown), text
    assert fault is None or one.message.fault_code == fault.code
    assert (len(one.uses) > 1) == (fault in (faults.PIN_CONFLICT, faults.PIN_UNUSABLE))
    assert fault is faults.PIN_UNUSABLE or all(use in text for use in one.uses)
    assert one.message.remedy is not None

    status, printed, _ = run("robot_config", "check", folder)
    assert status == int(refused) and text in printed and str(one.message.remedy) in printed
    status, printed, _ = run("robot_config", "check", "--json", folder)
    (record,) = json.loads(printed)
    received = received_message("", json.dumps(record))
    assert status == int(refused)
    assert (received, received.cause) == (one.message, one.message.cause)
    assert (record["file"], record["key"], tuple(record["uses"])) == (one.file, key, one.uses)
    launch = ("--part", "survey", "--robot", "gpr20", "--config", folder)
    status, configuration, said = run("check_launch", *launch)
    assert status == int(refused) and text in said
    assert bool(configuration) == (not refused)


def test_every_fault_of_the_check_has_an_example():
    known = {one.code for one in vars(faults).values() if hasattr(one, "code")}
    shown = {mistake[4].code for mistake in MISTAKES if mistake[4] is not None}
    assert {one for one in known if one.startswith("config.")} - shown == {
        *("config.unreadable", "config.no_folder", "config.old_launch", "config.files_exist"),
        *("config.unusable_extension", "config.unchecked_analyzer"),
    }


def test_all_mistakes_are_found_at_once_the_gravest_first(tmp_path):
    axes = "x: {dir_pin: 14, max_coord: 650 mm, step_size: 0,01}\ny: {sensor_pin: 11, q: 1}"
    folder = tmp_path / "robot"
    write(folder, {"axes": axes, "survey": "settle_s: -1", "site": "nobody: 1", "a.bak": ""})
    found = checked(folder)
    assert {one.key for one in found[:-1]} == {
        *("x/step_size", "x/dir_pin", "x/max_coord", "y/q", "z/dir_pin", "settle_s", "nobody"),
    }
    assert [one.refuses for one in found] == [True] * 7 + [False]


@each_case(
    "files",
    [
        {},
        {"axes": "x: {enable_pin: 18}\ny: {enable_pin: 18}\nz: {enable_pin: 18}"},
        {"axes": "x: {controller: 'a.b:C', dir_pin: 19}"},  # it has no pins
        {"axes": "y: {sensor_pin: 7}\nz: {dir_pin: 40}\nx: {backend: pigpio}"},
        {"axes": "x: {max_coord: 600}\nz: {step_size: 0.9}", "site": "site: Bogotá"},
        {"height": "spi_device: 1", "axes": "x: {sensor_pin: 7}"},
        {"storage": "data: ~/surveys"},
        {"analyzer": f"{VNA}settle_s: 1.0e-1", "README.md": "of robot 2", ".hidden": ""},
    ],
)
def test_a_correct_configuration_has_no_problem(tmp_path, run, files):
    folder = tmp_path / str(len(str(files)))
    write(folder, files)
    assert checked(folder) == checked(folder, BOTH) == ()
    assert "is correct" in run("robot_config", "check", folder)[1]


@each_case(
    "environment, key, refused, shown",
    [
        ({**BOTH, "GPR20_SERVER": "192.168.1.2"}, "GPR20_SERVER", True, "GPR20_ROBOT"),
        ({**BOTH, "GPR20_ROBOT": "192.168.1.10"}, "address", True, "GPR20_ROBOT"),
        ({"GPR20_ROBOT": "192.168.1.2"}, "GPR20_ROBOT", False, "GPR20_SERVER is empty"),
        ({**BOTH, "GPR20_SERVER": "127.0.0.1"}, "GPR20_SERVER", True, "for itself"),
        ({**BOTH, "GPR20_SERVER": "server.local"}, "GPR20_SERVER", True, "four numbers"),
    ],
)
def test_two_computers_and_the_analyzer_have_addresses_of_their_own(
    tmp_path, environment, key, refused, shown
):
    write(tmp_path / "robot", {})
    (one,) = checked(tmp_path / "robot", environment)
    assert (one.message.fault_code, one.key) == (faults.ADDRESS.code, key)
    assert one.refuses == refused and shown in str(one.message)
    assert checked(tmp_path / "robot", environment, real=False) == ()


def test_the_data_folder_of_the_launch_counts_and_only_where_surveys_are_stored(tmp_path):
    write(tmp_path / "robot", {"storage": f"data: {tmp_path}/robot/storage.yaml/x"})
    found = checked(tmp_path / "robot")
    assert {(one.key, one.refuses) for one in found} == {("data", True)}
    assert checked(tmp_path / "robot", stores=False) == ()
    write(tmp_path / "robot", {"storage": "data: /etc"})
    assert checked(tmp_path / "robot", data="~/surveys") == ()
    assert [one.refuses for one in checked(tmp_path / "robot", data="/proc/surveys")] == [True]


def test_what_cannot_be_read_is_not_taken_for_the_defaults(tmp_path):
    (tmp_path / "file").write_text("")
    (one,) = checked(tmp_path / "file", stores=False)
    assert one.message.fault_code == faults.UNREADABLE.code and one.refuses
    (one,) = checked(tmp_path / "none", stores=False)
    assert one.message.fault_code == faults.NO_FOLDER.code and not one.refuses
    # A robot that needs no values of its own needs no folder.
    assert checked(tmp_path / "home/.gpr20/robot", stores=False) == ()


def test_sizes_are_those_of_the_description(tmp_path):
    frame = read_frame(BUILT.urdf)
    assert frame.travel["y"] == (0.0, 800.0) and frame.travel["z"][1] == pytest.approx(90.0)
    assert frame.outer_mm == pytest.approx({"x": 880.0, "y": 1030.0}, abs=0.1)
    write(tmp_path / "robot", {})
    for text in ("<robot/>", "<robot", BUILT.urdf.read_text().replace("<box", "<sphere")):
        broken = tmp_path / "gpr20.urdf"
        broken.write_text(text)
        with pytest.raises(DescriptionError):
            read_frame(broken)
        (one,) = check_robot(tmp_path / "robot", BuiltRobot(BUILT.axes, broken), {})
        assert not one.refuses and str(broken) in str(one.message)


def test_the_header_has_forty_pins_and_every_bus_its_own_lines():
    assert {*GPIO_OF_BOARD, *NOT_GPIO} == set(range(1, 41))
    assert BOARD_OF_GPIO[17] == 11 and len(BOARD_OF_GPIO) == 28
    for bus in SPI_BUSES.values():
        for device in range(len(bus.selects)):
            assert len(set(bus.pins(device).values())) == 4


@each_case("profile", sorted(path.name for path in PROFILES.iterdir()))
def test_a_profile_is_correct_but_for_what_a_person_must_check(tmp_path, run, profile):
    folder = tmp_path / profile
    status, printed, _ = run("robot_config", "create", "--profile", profile, folder)
    assert status == 0 and all(f"unchecked is {one.value}" in printed for one in Unchecked)
    write(folder, {})
    found = checked(folder)
    assert {one.message.fault_code for one in found} == {faults.NOT_CHECKED.code}
    assert (
        {one.value for one in found}
        == {one.value for one in Unchecked}
        == {one.value for one in TASKS}
    )
    assert {one.value for one in found if not one.refuses} == {one.value for one in WITH_ROBOT}
    (folder / "wiring.yaml").write_text("unchecked: []")
    assert checked(folder) == ()
    # Beside other files it would have no effect.
    before = {path: path.read_bytes() for path in folder.iterdir()}
    status, _, said = run("robot_config", "create", "--profile", profile, folder)
    assert status == 1 and "axes.yaml" in said and faults.FILES_EXIST.remedy.template in said
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_files_of_a_profile_without_its_list_of_checks_are_refused(tmp_path, run):
    folder = tmp_path / "pcb"
    run("robot_config", "create", "--profile", "gpr20_pcb", folder)
    listed = [one for one in checked(folder) if one.refuses]
    (folder / "wiring.yaml").unlink()
    unlisted = [one for one in checked(folder) if one.refuses]
    assert {Path(one.file).name for one in unlisted} >= {"axes.yaml"}
    for problems in (listed, unlisted):
        assert {one.message.fault_code for one in problems} >= {faults.NOT_CHECKED.code}
