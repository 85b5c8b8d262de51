"""The check of the whole robot: one function, and what command, launch and programs get of it."""

import errno
import importlib.util
import json
from pathlib import Path
from typing import get_args
from unittest import mock

import pytest
from case_kit import each_case
from robot_check_examples import PROFILES, VNA, checked, write

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.message import received_message, verbatim
from gpr20_launch.faults import NOT_CHECKED
from gpr20_launch.mid import robot_check
from gpr20_launch.mid.robot_files import FILES, Before, WithRobot
from gpr20_vna_acquisition.mid.analyzers import Result, Status, store
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SENSOR = "topic: soil/values, message: std_msgs/Float64, field: data"
TWICE = f"sensors: [{{name: a, {SENSOR}}}, {{name: b, {SENSOR}}}]"
NO_TYPE = "sensors: [{name: a, topic: b, message: no_msgs/No, field: data}]"
NO_FIELD = "sensors: [{name: a, topic: b, message: std_msgs/Float64, field: dat}]"
NO_CLASS = f"{VNA}analyzer: nowhere.vna:Vna"
NO_CONTROLLER = "x: {controller: 'subprocess:Popen', controller_options: {args: 'true'}}"
LEVELS = "x: {enable_pin: 18}\ny: {enable_pin: 18, enable_active: high}"
OF_PROFILE = {*get_args(Before), *get_args(WithRobot)} - {"unread"}
# File and text; key, after the other file that has it; what must be said; code, if another.
MISTAKES = [
    # Pins, with everything that uses them.
    ("axes", "y: {sensor_pin: 11}", "z/dir_pin", "GPIO17|axes.yaml y/sensor_pin|continuity"),
    ("axes", LEVELS, "y/enable_pin", "x/enable_pin|enable_active"),
    ("axes", "y: {sensor_pin: 24}", "height.yaml spi_device", "pin 24|SPI0 CE0"),
    ("height", "spi_bus: 5\nspi_device: 1", "spi_device", "y/dir_pin|SPI5 CE1"),
    ("height", "spi_bus: 2", "spi_bus", "0, 1, 3, 4, 5, 6"),
    ("height", "spi_device: 2", "spi_device", "chip select|0 - 1"),
    ("axes", "x: {dir_pin: 28}", "x/dir_pin", "EEPROM|connected to it: 7|29, 31"),
    ("axes", "x: {dir_pin: 17}", "x/dir_pin", "pin 17 is 3.3 V|BOARD"),
    ("axes", "x: {dir_pin: GPIO27}", "x/dir_pin", "GPIO27|whole number"),
    (
        "axes",
        "x: {sensor_pin: 5, endstop_pull: none}",
        "x/endstop_pull",
        "1.8 kOhm|measure|endstop_active",
    ),
    ("axes", NO_CONTROLLER, "x/controller", "subprocess:Popen|begin_homing"),
    ("axes", "z: {sensor_pin: 5}", "z/sensor_pin", "homing_backoff has its default"),
    # Travel, steps, speed.
    ("axes", "y: {max_coord: 80000}", "y/max_coord", "80000 mm|20 to 3000 mm|measure how far"),
    ("axes", "x: {max_coord: '1,000'}", "x/max_coord", "1,000|number"),
    ("axes", "z: {min_coord: 0, max_coord: 270}", "z/max_coord", "270 deg|cables"),
    ("axes", "x: {step_size: 0.001}", "x/step_size", "1.8 hours|first_real_survey.md"),
    (
        *("axes", "x: {step_size: 0.1, min_step: 0.00005, late_limit_s: 0.00003}"),
        *("x/min_step", "1000 mm/s"),
    ),
    ("axes", "x: {min_step: 0.0002}", "x/min_step", "x: late_limit_s|has its default"),
    ("axes", "x: {type: ROT}", "x/type", "LIN"),
    # Typing errors.
    ("axes", "x: {step_size: 0,01}", "x/step_size", "a point, not a comma"),
    ("axes", "x:\n  dir_pin:13", "x", "dir_pin:13|colon"),
    ("axes", "x:\n\tdir_pin: 13", "", "line 2|'\\t'"),
    ("site", "site: a\nrobot:\u00a0b", "", "line 2|not YAML"),
    ("survey", b"\x7fELF\x02\x01\x00", "", "not YAML|#x007f"),
    ("axes", "x: {step_pin: '15'}", "x/step_pin", "'15'|whole number"),
    ("axes", "x: {delta_step: 1e-4}", "x/delta_step", "1e-4|number"),
    ("analyzer", f"{VNA}min_frequency_hz: 2.0e9", "min_frequency_hz", "2.0e9|number"),
    ("axes", "x: {max_coord: 650 mm}", "x/max_coord", "650 mm|number"),
    ("axes", "x: {max_cord: 900}", "x/max_cord", "max_coord"),
    ("axes", "x: {dir_pin: 013}", "x/dir_pin", "013|whole number"),
    ("axes", "x: {max_coord: 10:50}", "x/max_coord", "10:50"),
    ("axes", "dir_pin: 13", "dir_pin", "x, y, z"),
    ("axes", "x: {dir_pin: 13, dir_pin: 15}", "", "dir_pin|twice"),
    ("site", "latitude_deg: 4,6\nlongitude_deg: 1", "latitude_deg", "'4,6'|number"),
    ("site", "latitude_deg: 104\nlongitude_deg: 4", "latitude_deg", "104|90"),
    ("site", "# 4\nsite: Bogotá".encode("latin-1"), "", "not YAML|#x00e1"),
    # Data, addresses, sensors, wiring, files.
    ("storage", "data: surveys", "data", "absolute path, such as /srv/gpr20"),
    ("storage", "data: /etc/surveys", "data", "/etc/surveys|system|GPR20_DATA"),
    ("storage", "data: /tmp", "data", "/tmp|every program"),
    ("analyzer", "address: 224.0.0.1", "address", "224.0.0.1"),
    ("analyzer", "address: 192.168.1.255", "address", "192.168.1.255"),
    ("analyzer", "address: 192.168.1.300", "address", "192.168.1.300|192.168.1.10"),
    ("analyzer", NO_CLASS, "analyzer", "nowhere.vna|cannot be imported|install"),
    ("sensors", "sensors: [{name: soil}]", "sensors", "topic"),
    ("sensors", NO_TYPE, "sensors[0]", "no_msgs/No is not installed"),
    ("sensors", NO_FIELD, "sensors[0]", "no number dat;|data (float64)"),
    (
        "wiring",
        "unchecked: [pins]",
        "unchecked",
        "pins|docs/coming_from_the_original.md|corrected the files",
        "config.not_checked",
    ),
    ("hight", "", "", "hight.yaml|height.yaml|rename it"),
    # Of one record: types, choices, lists, groups, names.
    ("height", "reference_voltage_v: '3.3'", "reference_voltage_v", "'3.3'|number"),
    ("analyzer", "accepted_calibrations: [1, 9]", "accepted_calibrations", "[1]|9"),
    ("analyzer", "analyzer: hp8753", "analyzer", "'hp8753'|ms2026c, gpr20_scikit_rf:Scikit"),
    ("survey", "on_height_failure: guess", "on_height_failure", "pause, store_without"),
    ("survey", "- a list", "", "key: value"),
    ("storage", "extra_recorded_topics: [a b]", "", "'a b'"),
    ("axes", "x: {max_step: 0.001}", "x/max_step", "min_step has its default"),
    ("axes", "x: {enable_pin: 18, enable_active: []}", "x/enable_active", "one of low, high"),
    ("axes", "x: 0", "x", "group of values"),
]
DOUBTS = [
    ("axes", "z: {min_coord: 10}", "z/min_coord", "10 deg|<= 0 deg"),
    ("axes", "x: {enable_pin: 26}", "x/enable_pin", "CE1"),
    ("axes", "x: {step_pin: 8}", "x/step_pin", "console"),
    ("axes", "x: {dir_pin: 3}", "x/dir_pin", "1.8 kOhm"),
    ("axes", "y: {max_coord: 880}", "y/max_coord", "880 mm|URDF|0 - 800 mm"),
    ("axes", "x: {max_coord: 65}", "x/max_coord", "much longer|in mm"),
    ("axes", "z: {max_coord: 45}", "z/max_coord", "0 and 90"),
    ("axes", "z: {min_coord: -1.57, max_coord: 1.57}", "z/max_coord", "1.57 deg"),
    ("axes", "z: {step_size: 7}", "z/step_size", "turn to 91"),
    (
        *("axes", "x: {min_step: 0.0004, max_step: 0.0004, late_limit_s: 0.0003}"),
        *("x/max_step", "1250 steps per second"),
    ),
    ("axes", "z: {min_step: 0.0009, delta_step: 0.02}", "z/delta_step", "deg/s2"),
    ("axes", "x: {late_limit_s: 0.0015}", "x/late_limit_s", "<= 0.0012 s"),
    ("storage", "data: ~/no_such_disk/surveys", "data", "does not exist"),
    ("storage", "data: /media/usb/surveys", "data", "data_disk: true"),
    ("storage", "disk_reserve_mb: 900000000", "disk_reserve_mb", "can start", "disk.full"),
    (
        "storage",
        "signing_key: /nowhere/key",
        "signing_key",
        "/nowhere/key|not signed",
        "survey.not_signed",
    ),
    ("survey", "settle_s: 0", "settle_s", "swing"),
    ("survey", "reference_interval_s: 1", "reference_interval_s", ">= 60 s"),
    ("web", "port: 11311", "port", "11311|ROS master"),
    ("web", "address: 0.0.0.0", "address", "0.0.0.0|every network|its address in the"),
    ("axes", "z: {delta_step: 0.02}", "z/delta_step", "max_step 0.025|<= 0.015 s"),
    ("axes", "y: {step_size: 0.1}", "y/step_size", "0.1 mm|0.002 - 0.05 mm"),
    ("analyzer", f"{VNA}antenna_delay_ns: 1.9e-9", "antenna_delay_ns", "seconds"),
    ("analyzer", "address: 127.0.0.1", "address", "127.0.0.1"),
    (
        *("analyzer", f"{VNA}accepted_calibrations: [1, 0]", "accepted_calibrations"),
        "without a calibration",
    ),
    ("height", "reference_voltage_v: 5.0", "reference_voltage_v", "5 V|MISO|level shifter"),
    ("sensors", TWICE, "sensors[1]/field", "sensor a"),
]
BOTH = {"GPR20_ROBOT": "192.168.1.2", "GPR20_SERVER": "192.168.1.3"}


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))
    monkeypatch.delenv("GPR20_DATA", raising=False)
    monkeypatch.setattr(robot_check, "free_bytes", lambda _folder: 5e10)
    (tmp_path / "home/surveys").mkdir(parents=True)


# What sensors publish, the messages of ROS say.
HAS_ROS = importlib.util.find_spec("genpy") is not None


@each_case("case", [one for one in (*MISTAKES, *DOUBTS) if HAS_ROS or one[0] != "sensors"])
def test_a_mistake_is_found_once_with_file_key_value_and_uses(tmp_path, case):
    name, text, place, shown, *code = case
    folder = tmp_path / str([*MISTAKES, *DOUBTS].index(case))
    write(folder, {name: text})
    (one,) = checked(folder)
    text = str(one.message)
    file, _space, key = place.rpartition(" ")
    assert (Path(one.file).name, one.key) == (file or f"{name}.yaml", key), text
    assert one.refuses == (case in MISTAKES) and one.message.remedy is not None
    assert one.file in text and all(word in text for word in shown.split("|")), text
    assert [one.message.fault_code] == (code or [CONFIGURATION.code])


# The programs show all alike.
@each_case("case", [MISTAKES[0], DOUBTS[0]])
def test_command_launch_and_programs_get_the_same(tmp_path, run, case):
    refused, folder = case in MISTAKES, tmp_path / str([*MISTAKES, *DOUBTS].index(case))
    write(folder, {case[0]: case[1]})
    (one,) = checked(folder)
    text = str(one.message)
    status, printed, _ = run("robot_config", "check", folder)
    assert status == int(refused) and text in printed and str(one.message.remedy) in printed
    status, printed, _ = run("robot_config", "check", "--json", folder)
    (record,) = json.loads(printed)
    received = received_message("", record)
    assert status == int(refused)
    assert (received, received.cause) == (one.message, one.message.cause)
    assert (record["file"], record["key"]) == (one.file, one.key)
    launch = ("--part", "survey", "--robot", "gpr20", "--config", folder)
    status, configuration, said = run("check_launch", *launch)
    assert status == int(refused) and text in said
    assert bool(configuration) == (not refused)


@each_case(
    "file, text, wrong",
    [
        ("axes", "x: {min_stp: 0.01, step_size: 0.5}", {"x/min_stp"}),
        ("axes", "x: {max_coord: abc, min_coord: 700, dir_pin: 41}", {"x/max_coord", "x/dir_pin"}),
        ("axes", LEVELS.replace("high", "hi"), {"y/enable_active"}),
        ("axes", "x: {dir_pn: 37}\ny: {dir_pin: 13}", {"x/dir_pn"}),
        ("height", "spi_bu: 1\nspi_device: 2", {"spi_bu"}),
        ("height", "spi_bus: 1\nspi_bus: 0", {""}),
        ("storage", "daat: /media/x\ndisk_reserve_mb: -1", {"daat", "disk_reserve_mb"}),
        ("analyzer", "min_frequency: 7.0e+9\nmax_frequency_hz: 8.0e+3", {"min_frequency"}),
    ],
)
def test_no_mistake_follows_from_the_default_of_a_value_that_is_not_known(
    tmp_path, file, text, wrong
):
    folder = tmp_path / f"{file}{len(text)}"
    write(folder, {file: text})
    found = checked(folder)
    assert {one.key for one in found} == wrong and len(found) == len(wrong), found


class OwnAnalyzer:
    """A class for another analyzer."""

    connect = identify = check_sweep = configure = sweep = confirm = calibration = None
    release = disconnect = trace_duration_s = remarks = None

    def __init__(self, parameters, deadline, port=1):
        if port < 0:
            raise InvalidValueError(verbatim(f"port is {port}"))


def test_a_class_of_analyzer_checks_its_options_and_is_doubtful_until_it_passed_its_check(tmp_path):
    own, folder = f"{__name__}:OwnAnalyzer", tmp_path / "robot"
    write(folder, {"analyzer": f"{VNA}analyzer: {own}\nanalyzer_options: {{port: -1}}"})
    (one,) = checked(folder, part="server")
    assert one.message.fault_code == CONFIGURATION.code and "port is -1" in str(one.message)
    write(folder, {"analyzer": f"{VNA}analyzer: {own}"})

    def codes(**options):
        return [one.message.fault_code for one in checked(folder, **options)]

    assert codes(part="robot") == codes(real=False) == []
    for status in (Status.FAILED, Status.PASSED):
        assert codes() == codes(part="server") == [NOT_CHECKED.code]
        found = [Result("identity", status, verbatim("found"))]
        store(folder, VnaParameters(analyzer=own), found)
    assert codes() == []


@pytest.mark.skipif(not HAS_ROS, reason="could not import 'genpy'")
def test_classes_and_types_must_be_installed_where_they_are_used(tmp_path):
    write(tmp_path / "robot", {"axes": NO_CONTROLLER, "analyzer": NO_CLASS, "sensors": NO_TYPE})
    axis, server = {"x/controller"}, {"analyzer", "sensors[0]"}
    for part, real, wrong in (
        *(("robot", True, axis), ("server", True, server), ("survey", True, axis | server)),
        *(("survey", False, {"sensors[0]"}), ("robot", False, set())),
    ):
        found = checked(tmp_path / "robot", part=part, real=real)
        assert {one.key for one in found} == wrong, (part, real)


@each_case(
    "files",
    [
        {},
        {"axes": "\n".join(f"{axis}: {{enable_pin: 18, enable_active: high}}" for axis in "xyz")},
        {"axes": "y: {sensor_pin: 7}\nz: {dir_pin: 40}"},
        {"axes": "x: {max_coord: 600, dir_pin: 15, step_pin: 13}\nz: {step_size: 0.9}"},
        {"axes": "x: {endstop_active: high, endstop_pull: down}\ny: {endstop_active: high}"},
        {"height": "spi_device: 1\nreference_voltage_v: 3.31", "axes": "x: {sensor_pin: 7}"},
        {"storage": "data: ~/surveys", "sensors": f"sensors: [{{name: a, {SENSOR}}}]"},
        {
            "site": "robot: GPR-20 Ñandú\nlatitude_deg: 4.6\nlongitude_deg: -74.1",
            **{"analyzer": f"{VNA}settle_s: 1.0e-1", "README.md": "of robot 2", ".hidden": ""},
        },
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
    assert (one.message.fault_code, one.key) == (CONFIGURATION.code, key)
    assert one.refuses == refused and shown in str(one.message)
    assert checked(tmp_path / "robot", environment, real=False) == ()


def test_the_data_folder_of_the_launch_counts_and_only_where_surveys_are_stored(tmp_path):
    write(tmp_path / "robot", {"storage": f"data: {tmp_path}/robot/storage.yaml/x"})
    found = checked(tmp_path / "robot")
    assert {(one.key, one.refuses) for one in found} == {("data", True)}
    assert checked(tmp_path / "robot", part="robot") == ()
    (one,) = checked(tmp_path / "robot", data=str(tmp_path / "robot/storage.yaml"))
    assert "it is no folder" in str(one.message) and one.refuses
    write(tmp_path / "robot", {"storage": "data: /etc"})
    assert checked(tmp_path / "robot", data="~/surveys") == ()
    assert [one.refuses for one in checked(tmp_path / "robot", data="/proc/surveys")] == [True]


def test_what_cannot_be_read_is_not_taken_for_the_defaults(tmp_path, run):
    (tmp_path / "file").write_text("")
    (one,) = checked(tmp_path / "file", part="robot")
    assert one.message.fault_code == CONFIGURATION.code and one.refuses
    assert run("robot_config", "check", tmp_path / "none")[0] == 1
    (one,) = checked(tmp_path / "none", part="robot")
    assert one.message.fault_code == CONFIGURATION.code and one.refuses
    # A robot that needs no values of its own needs no folder.
    assert checked(tmp_path / "home/.gpr20/robot", part="robot") == ()


@each_case("profile", sorted(path.name for path in PROFILES.iterdir()))
def test_a_profile_is_correct_but_for_what_a_person_must_check(tmp_path, run, profile):
    folder = tmp_path / profile
    status, printed, _ = run("robot_config", "create", "--profile", profile, folder)
    assert status == 0 and all(f"unchecked is {one}" in printed for one in OF_PROFILE)
    write(folder, {})
    found = checked(folder)
    assert {one.message.fault_code for one in found} == {NOT_CHECKED.code}
    assert {one.value for one in found} == OF_PROFILE
    assert {one.value for one in found if not one.refuses} == {*get_args(WithRobot)}
    for nothing in ("unchecked: []", "unchecked:"):
        (folder / "wiring.yaml").write_text(nothing)
        assert checked(folder) == ()
    # Beside other files it would have no effect.
    before = {path: path.read_bytes() for path in folder.iterdir()}
    status, _, said = run("robot_config", "create", "--profile", profile, folder)
    assert status == 1 and "axes.yaml" in said and NOT_ALLOWED.remedy.template in said
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_profile_that_was_written_in_part_is_refused_as_the_whole_is(tmp_path, run):
    for whole in range(1, len(FILES) + 1):
        folder, made = tmp_path / str(whole), []

        def open_some(path, mode="r", *given, made=made, whole=whole, **more):
            made += [path] * (mode == "x")
            if len(made) > whole:
                raise OSError(errno.ENOSPC, "full")
            return open(path, mode, *given, **more)

        with mock.patch.object(Path, "open", open_some):
            run("robot_config", "create", "--profile", "gpr20_pcb", folder)
        refusing = {one.value for one in checked(folder) if one.refuses}
        assert refusing >= OF_PROFILE - {*get_args(WithRobot)}, sorted(folder.iterdir())
