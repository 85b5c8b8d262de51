"""The probes: of trees of files as computers have them, and of this computer."""

import errno
import os
import socket
import threading
from pathlib import Path
from unittest import mock

import pytest

from gpr20_common.message import Message
from gpr20_doctor.low import network, pi, programs, system
from gpr20_doctor.mid import machine_probe
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse, PortFacts
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import MachineRequest
from gpr20_survey.faults import OTHER_DATA_FOLDER
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse, KnownFolder


def tree(folder, **files):
    for name, content in files.items():
        path = folder / name.replace("__", "/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    return folder


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Return a function that makes a program, and lets nothing but the shell be found else."""

    def make(name, script):
        path = tmp_path / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        monkeypatch.setenv("PATH", f"{path.parent}:/bin")

    return make


def test_groups_devices_and_temperature_are_read_as_the_system_writes_them(tmp_path):
    user, own = pi.groups(Path("/")).user, os.getegid()
    tree(tmp_path, etc__group=f"gpio:x:997:pi,{user}\nspi:x:{own}:\nbroken\nodd:x:a:\n")
    found = pi.groups(tmp_path)
    assert (found.existing, found.listed, found.member) == ({"gpio", "spi"}, {"gpio"}, {"spi"})
    assert pi.pins(tmp_path).devices == ()
    tree(tmp_path, dev__gpiomem="", dev__gpiochip0="")
    devices = pi.pins(tmp_path).devices
    assert [one.path.name for one in devices] == ["gpiomem", "gpiochip0"]
    assert all(one.exists and one.usable for one in devices)
    missing = pi.spi_device(tmp_path, 0, 1)
    assert not missing.exists and not missing.usable
    assert pi.hottest_c(tmp_path) is None
    zone = "sys__class__thermal__thermal_zone"
    tree(tmp_path, **{f"{zone}0__temp": "45000\n", f"{zone}1__temp": "81500\n"})
    assert pi.hottest_c(tmp_path) == 81.5
    tree(tmp_path, **{f"{zone}1__temp": "hot\n"})
    with pytest.raises(ValueError):
        pi.hottest_c(tmp_path)


def test_the_supply_of_a_raspberry_pi_is_found_among_other_sensors(tmp_path, stand_in):
    stand_in("other", "")
    hwmon = "sys__class__hwmon__hwmon"
    tree(tmp_path, **{f"{hwmon}0__name": "cpu_thermal\n"})
    with pytest.raises(ValueError):
        pi.power(tmp_path)
    tree(tmp_path, **{f"{hwmon}1__name": "rpi_volt\n", f"{hwmon}1__in0_lcrit_alarm": "1\n"})
    assert pi.power(tmp_path) == pi.Power(True)
    assert not pi.is_raspberry_pi(tmp_path)
    tree(tmp_path, **{"proc__device-tree__model": "Raspberry Pi 4 Model B Rev 1.4\0"})
    assert pi.is_raspberry_pi(tmp_path)


TRACKING = "0A140002,10.20.0.2,3,1763845122.1,{offset},0,0,-1.5,0,0,0.001,0.001,64.2,{leap}"
NORMAL = TRACKING.format(offset="-0.000012", leap="Normal")
ALONE = TRACKING.format(offset="0", leap="Not synchronised")
ADVISED = Message("the pin is used twice").with_fault(OTHER_DATA_FOLDER)


def power():
    return pi.power(Path("/no-such-root"))


ASKED = "/e gpr20_launch robot_config check --json --robot gpr20 --part robot --data /d /c"


def check():
    return programs.problems(Path("/c"), "/d", "gpr20", "robot", {"GPR20_DATA": "/e"})


@pytest.mark.parametrize(
    "ask, name, script, expected",
    [
        (power, "vcgencmd", "echo throttled=0x50000", pi.Power(False, True)),
        (power, "vcgencmd", "echo throttled=0x1", pi.Power(True, False)),
        (power, "vcgencmd", "echo nothing", ValueError),
        (programs.tracking, "chronyc", f"echo '{NORMAL}'", (True, -0.000012)),
        (programs.tracking, "chronyc", f"echo '{ALONE}'", (False, 0.0)),
        (programs.tracking, "chronyc", "echo 506 Cannot talk to daemon", ValueError),
        (check, "rosrun", f'test "$GPR20_DATA $*" = "{ASKED}" && echo "[]"', ()),
        (check, "rosrun", f"cat <<'END'\n[{ADVISED.to_json()}]\nEND\nexit 1", (ADVISED,)),
        (check, "rosrun", "echo '{\"a\": 1}'", ValueError),
        (check, "rosrun", "echo 'unrecognized arguments' >&2; exit 2", OSError),
    ],
)
def test_a_program_that_is_asked_is_understood_and_may_fail(stand_in, ask, name, script, expected):
    stand_in(name, script)
    if isinstance(expected, type):
        with pytest.raises(expected):
            ask()
    else:
        found = ask()
        assert found == expected
        assert expected != (ADVISED,) or found[0].fault_code == ADVISED.fault_code


def test_a_disk_is_timed_and_nothing_is_left_on_it(tmp_path, monkeypatch):
    seen, fsync = [], os.fsync

    def synchronize(file):
        seen.append(list(tmp_path.iterdir()))
        fsync(file)

    monkeypatch.setattr(os, "fsync", synchronize)
    assert system.slowest_trace_s(tmp_path, 300_000) > 0.0
    # While it is written, the file has no name.
    assert seen and all(names == [] for names in [*seen, list(tmp_path.iterdir())])
    with pytest.raises(OSError):
        system.slowest_trace_s(tmp_path / "missing", 300)


def test_ports_and_addresses():
    assert network.is_own_address("127.0.0.1")
    assert not network.is_own_address("192.0.2.1")
    assert not network.is_own_address("robot")
    assert network.addresses_of("127.0.0.1") == network.addresses_of("localhost") == {"127.0.0.1"}
    assert network.addresses_of("no.such.name.invalid") == frozenset()
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        network.connect("127.0.0.1", port, 1.0)
    with pytest.raises(OSError):
        network.connect("127.0.0.1", port, 1.0)


def test_limits_and_libraries_of_this_computer():
    before = os.sched_getscheduler(0)
    assert pi.realtime(1).priority >= -1
    assert os.sched_getscheduler(0) == before
    assert pi.is_installed("json") and not pi.is_installed("no_such.module")


def test_memory_and_what_runs_and_listens_are_read_as_linux_writes_them(tmp_path):
    tree(tmp_path, proc__meminfo="MemAvailable:  1000 kB\n", proc__vmstat="oom_kill 3\n")
    assert system.memory(tmp_path) == (1_024_000, 3)
    tree(tmp_path, proc__meminfo="MemFree: 1 kB\n")
    with pytest.raises(ValueError):
        system.memory(tmp_path)
    with pytest.raises(OSError):
        system.listening(tmp_path)
    lines = ["sl local remote st", " 0: 0100007F:2C2F 0:0 0A 0", " 1: 0200140A:2C2F 0:0 01 0"]
    tree(tmp_path, proc__net__tcp="\n".join(lines))
    anywhere = f"sl\n 0: {'0' * 32}:0050 0:0 0A 0\n 1: {'1' * 32}:0051 0:0 0A 0"
    tree(tmp_path, proc__net__tcp6=anywhere)
    assert system.listening(tmp_path) == [("127.0.0.1", 11311), ("0.0.0.0", 80)]


def processes(folder, *rows):
    """Write processes: number, parent, command line and environment, both with blanks between."""
    for number, parent, words, environment in rows:
        tree(
            folder,
            **{
                f"proc/{number}/cmdline": words.replace(" ", "\0") + "\0",
                f"proc/{number}/environ": environment.replace(" ", "\0"),
                f"proc/{number}/stat": f"{number} (a b) S {parent} 1",
            },
        )
    return system.ros_processes(folder)


PC = "ROS_MASTER_URI=http://pc:11311"


def test_masters_nodes_and_launches_are_found(tmp_path):
    launch = "python3 /opt/ros/bin/roslaunch gpr20"
    (tmp_path / "proc" / "16").mkdir(parents=True)
    (tmp_path / "proc" / "16" / "cwd").symlink_to("/etc")
    found = processes(
        tmp_path,
        (11, 1, "python3 /opt/ros/bin/rosmaster --core -p 11712", ""),
        (12, 1, "node __name:=main_control", f"A=1 {PC}/ ROS_IP=10.20.0.1"),
        (13, 1, "node __name:=imaging", "ROS_MASTER_URI=http://192.0.2.50:11312"),
        (14, 1, f"{launch} config:=/etc/mole", f"{PC} GPR20_CONFIG=/o"),
        (15, 1, launch, "ROS_MASTER_URI=http://pi:11311 GPR20_CONFIG=/o"),
        (16, 1, f"{launch} config:=mole", "ROS_MASTER_URI=http://own:11311"),
        (17, 1, f"{launch} config:=mole", "ROS_MASTER_URI=http://other:11311"),
    )
    assert found.ports == [11712]
    (node,) = found.nodes_of("http://pc:11311")
    assert node == (12, "http://pc:11311", "10.20.0.1", False, "", "")
    assert [one.number for one in found.nodes_of("http://127.0.0.1:11312/")] == [13]
    # A folder is known from where its launch was started, if that can be seen.
    folders = [found.configuration(f"http://{one}:11311/") for one in ("pc", "pi", "own", "other")]
    assert folders == [Path("/etc/mole"), Path("/o"), Path("/etc/mole"), None]


def test_a_node_is_left_over_when_no_launch_is_above_it(tmp_path):
    found = processes(
        tmp_path,
        (1, 0, "init", ""),
        (20, 1, "python3 /opt/ros/bin/roslaunch gpr20 survey.launch", ""),
        (21, 20, "xterm -e node __name:=a __log:=/l", ""),
        (22, 21, "node __name:=a __log:=/l", ""),
        (23, 1, "node __name:=b __log:=/l", ""),
        (24, 1, "node __name:=by_hand", ""),
        (25, 99, "node __name:=c __log:=/l", ""),
    )
    assert sorted(one.number for one in found.nodes if one.left_over) == [23]


def test_the_watchdog_of_each_launch_and_what_it_does_is_found(tmp_path):
    master = "ROS_MASTER_URI=http://localhost:11311"
    processes(
        tmp_path,
        (30, 1, "python3 /l/watchdog --launch=/first __name:=watchdog", master),
        (32, 1, "node configuration:=/first __name:=a", master),
        (33, 1, "node configuration:=/second __name:=a", master),
        (34, 1, "node configuration:=/other __name:=a", "ROS_MASTER_URI=http://pc:11312"),
        (35, 1, "node __name:=rviz", master),
    )
    request = MachineRequest(HardwareUse.ELSEWHERE, {}, root=tmp_path)
    assert sorted(probe_machine(request).watchdogs) == ["", "S"]


def test_a_computer_without_anything_is_known_to_have_nothing(tmp_path):
    # A folder that does not exist yet has the disk of its parent.
    request = MachineRequest(
        HardwareUse.NEEDED, {}, data=tmp_path / "a/b", vna="127.0.0.1", root=tmp_path / "empty"
    )
    facts = probe_machine(request)
    assert isinstance(facts.groups, Unknown)
    assert (facts.spi.exists, facts.spi.usable) == (False, False)
    assert facts.gpio.devices == ()
    assert facts.power is None and facts.temperature_c is None
    assert facts.disk.free_bytes > 0
    assert isinstance(facts.vna, PortFacts)
    assert not (tmp_path / "a").exists()


def test_a_raspberry_pi_that_shows_nothing_is_not_called_good(tmp_path):
    tree(tmp_path, **{"proc__device-tree__model": "Raspberry Pi 4"})
    facts = probe_machine(MachineRequest(HardwareUse.NEEDED, {}, thorough=False, root=tmp_path))
    assert isinstance(facts.power, Unknown) and isinstance(facts.temperature_c, Unknown)
    assert facts.disk is None and facts.clock is None


def test_a_data_folder_that_is_gone_is_named_and_its_place_is_not_written_to(tmp_path):
    data, environment = tmp_path / "data", {"GPR20_STATE": str(tmp_path / "state")}
    request = MachineRequest(HardwareUse.ELSEWHERE, environment, data=data)
    assert probe_machine(request).disk.known == KnownFolder("", False)
    folder = DataFolder(DataFolderUse(data, tmp_path / "state"))
    folder.check()
    assert probe_machine(request).disk.known == folder.identify()
    data.rename(tmp_path / "moved")
    disk = probe_machine(request).disk
    assert disk.known.fault_code == OTHER_DATA_FOLDER.code and disk.trace_s is None
    assert not data.exists()


def test_what_this_user_may_not_read_may_be_right_for_the_storage(tmp_path, monkeypatch):
    refuse = mock.Mock(side_effect=PermissionError(errno.EACCES, "no"))
    request = MachineRequest(HardwareUse.ELSEWHERE, {}, data=tmp_path, thorough=False)
    monkeypatch.setattr("gpr20_survey.folder.data_folder.read_marker", refuse)
    assert isinstance(probe_machine(request).disk.known, Unknown)
    monkeypatch.setattr(machine_probe, "existing_folder", refuse)
    assert isinstance(probe_machine(request).disk, Unknown)


def test_a_disk_that_hangs_is_not_waited_for(monkeypatch, tmp_path):
    ended = threading.Event()
    monkeypatch.setattr(machine_probe, "DISK_LIMIT_S", 0.05)
    monkeypatch.setattr(machine_probe, "free_bytes", lambda _folder: ended.wait(60.0))
    request = MachineRequest(HardwareUse.ELSEWHERE, {}, data=tmp_path, thorough=False)
    assert isinstance(probe_machine(request).disk, Unknown)
    ended.set()
