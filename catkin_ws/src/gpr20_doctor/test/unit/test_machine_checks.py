"""What is wrong with a computer, from any facts about it."""

import math
from collections import ChainMap
from dataclasses import replace
from pathlib import Path

from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from test_robot_checks import ROBOTS, SAME, facts

from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low import pi
from gpr20_doctor.low.programs import Tracking
from gpr20_doctor.low.system import Memory
from gpr20_doctor.mid.finding import Level, Unknown
from gpr20_doctor.mid.findings import GOOD, exit_status, findings
from gpr20_doctor.mid.machine_facts import (
    AddressFacts,
    DiskFacts,
    HardwareUse,
    MachineFacts,
    OutsideFacts,
    PortFacts,
    VolumeFacts,
)
from gpr20_doctor.mid.place import Place
from gpr20_survey.faults import OTHER_DATA_FOLDER
from gpr20_survey.folder.data_folder import KnownFolder

SERVED = Place(Path("/etc/r"), Path("/log"), Path("/etc/e"), "gpr20-robot", Path("/usr/f"))
BOTH = frozenset({"gpio", "spi"})
SPI = pi.DeviceFile(Path("/dev/spidev0.0"), True, True)
PINS = pi.DeviceFile(Path("/dev/gpiomem"), True, True)
TWO = AddressFacts("10.20.0.1", "10.20.0.2", ("10.20.0.1",), "10.20.0.1")
ONE = AddressFacts("", "", (), "127.0.0.1")
GROUPS = pi.Groups("pi", False, BOTH, BOTH, BOTH)
GPIO = pi.Pins((PINS,), frozenset({"rpi_gpio"}), "rpi_gpio")
REALTIME = pi.Realtime(99, True, None)
DISK = DiskFacts(Path("/data"), 20_000_000_000, KnownFolder("0f8fad5b", True), 0.1)
HEALTHY = MachineFacts(
    hardware=HardwareUse.NEEDED,
    addresses=TWO,
    software=NodeSoftware("0.1.0"),
    temperature_c=50.0,
    groups=GROUPS,
    spi=SPI,
    gpio=GPIO,
    realtime=REALTIME,
    power=pi.Power(False),
    disk=DISK,
    clock=Tracking(True, 0.0001),
    vna=PortFacts("10.0.0.1", 111),
    two_computers=True,
    memory=Memory(2_000_000_000, 0),
    volumes=(VolumeFacts("/", Path("/var/log"), False, 10**10, 10**6),),
    outside=OutsideFacts(3),
    configuration=(),
)
VOLUME = HEALTHY.volumes[0]
OTHER = Message("/data is not the data folder").with_fault(OTHER_DATA_FOLDER)
GONE = Unknown(Message("permission denied"))


def test_a_healthy_computer_is_good():
    found = findings(None, HEALTHY)
    assert {one.level for one in found} == {Level.OK}
    assert exit_status(found) == GOOD


@each_case("use", [HardwareUse.SIMULATED, HardwareUse.ELSEWHERE, HardwareUse.NO_PI])
def test_a_computer_without_hardware_needs_none(use):
    found = findings(None, MachineFacts(use, ONE, NodeSoftware("0.1.0"), closed=True))
    assert exit_status(found) == GOOD
    assert not any(one.check in ("groups", "spi", "gpio", "realtime") for one in found)
    assert any(one.check == "hardware" and one.level is Level.NOTE for one in found)


OK, NOTE, UNKNOWN, WARNING, FAULT = Level
OPTIONAL = ("groups", "spi", "gpio", "realtime", "temperature_c", "power", "disk", "clock", "vna")
OPTIONAL += ("configuration", "outside", "memory", "volumes")
GPIO_ONLY = frozenset({"gpio"})
NO_PIGPIO = pi.Pins((), frozenset({"pigpio"}), "pigpio")
NO_VNA = PortFacts("10.0.0.1", 111, Message("connection refused"))
LEFT = replace(ONE, ros_address="10.0.0.7", foreign=("10.0.0.7",))
CASES = [
    ({"groups": replace(GROUPS, member=GPIO_ONLY)}, WARNING, "next login"),
    ({"groups": replace(GROUPS, member=GPIO_ONLY, listed=GPIO_ONLY)}, WARNING, "not in the group"),
    ({"groups": pi.Groups("pi", False, GPIO_ONLY, GPIO_ONLY, BOTH)}, WARNING, "no group spi"),
    ({"spi": replace(SPI, exists=False, usable=False)}, FAULT, "SPI bus is off"),
    ({"spi": replace(SPI, usable=False)}, FAULT, "cannot be read"),
    ({"gpio": replace(GPIO, libraries=frozenset())}, FAULT, "RPi.GPIO for the pins"),
    ({"gpio": replace(GPIO, devices=())}, FAULT, "pins cannot be used"),
    ({"gpio": NO_PIGPIO}, FAULT, "pigpio daemon does not answer"),
    ({"realtime": pi.Realtime(0, False, None)}, WARNING, "Real-time priority"),
    ({"realtime": pi.Realtime(99, True, 64_000)}, WARNING, "memory can be locked"),
    ({"temperature_c": 75.0}, WARNING, "75 °C"),
    ({"temperature_c": 81.0}, FAULT, "81 °C"),
    ({"power": pi.Power(True)}, FAULT, "too low now"),
    ({"power": pi.Power(False, True)}, WARNING, "too low since"),
    ({"disk": replace(DISK, free_bytes=10)}, FAULT, "0.0 GB"),
    ({"disk": replace(DISK, known=OTHER)}, FAULT, "not the data folder"),
    ({"disk": replace(DISK, known=KnownFolder("", False))}, UNKNOWN, "right data folder"),
    ({"disk": replace(DISK, trace_s=1.5)}, WARNING, "in 1.50 s"),
    ({"disk": replace(DISK, trace_s=float("inf"))}, FAULT, "did not store"),
    ({"clock": Tracking(False, 0.0)}, WARNING, "chrony does not follow"),
    ({"clock": Tracking(True, -2.0)}, WARNING, "off by -2.000 s"),
    ({"vna": NO_VNA}, FAULT, "10.0.0.1 cannot be reached"),
    ({"addresses": replace(TWO, own=())}, FAULT, "none of the addresses"),
    ({"addresses": replace(TWO, ros_address="127.0.0.1")}, FAULT, "listens on 127.0.0.1"),
    ({"addresses": replace(ONE, ros_address="")}, WARNING, "everybody in the network"),
    ({"addresses": LEFT}, FAULT, "ROS_IP or ROS_HOSTNAME is 10.0.0.7"),
    ({"addresses": replace(TWO, foreign=("10.0.0.7",))}, FAULT, "listen on 10.0.0.7"),
    ({"configuration": (Message("the pin is used twice"),)}, FAULT, "used twice"),
    ({"left_over": (7, 5)}, WARNING, "The launch of 2 parts"),
    ({"watchdogs": ("S", "")}, UNKNOWN, "No watchdog runs here"),
    ({"watchdogs": ("S", "T", "")}, FAULT, "Watchdog hangs"),
    ({"outside": OutsideFacts(3, (11311, 4))}, FAULT, "(11311, 4)"),
    ({"outside": OutsideFacts(1, (9,), True)}, FAULT, "(9)"),
    ({"outside": None}, UNKNOWN, "where ROS listens"),
    ({"memory": Memory(150_000_000, 0)}, WARNING, "150 MB free"),
    ({"memory": Memory(50_000_000, 0)}, FAULT, "50 MB free"),
    ({"memory": Memory(10**9, 2)}, WARNING, "ended 2 programs"),
    ({"volumes": (replace(VOLUME, read_only=True),)}, FAULT, "is read-only"),
    ({"volumes": (replace(VOLUME, free_bytes=10**8),)}, WARNING, "100 MB left"),
    ({"volumes": (replace(VOLUME, free_bytes=10**6),)}, FAULT, "1 MB left"),
    ({"volumes": (replace(VOLUME, free_files=3),)}, FAULT, "3 more files"),
    ({"behind_s": 864000.0}, WARNING, "10 days before"),
    ({"temperature_c": math.nan}, UNKNOWN, "the processor's temperature"),
    *[({name: GONE}, UNKNOWN, "permission denied") for name in ("addresses", *OPTIONAL)],
]


@each_case("changes, level, words", CASES)
def test_each_fault_is_found(changes, level, words):
    found = findings(None, replace(HEALTHY, **changes))
    (fault,) = [one for one in found if words in str(one.text)]
    assert (fault.level, found[0].level) == (level, level)
    assert fault.remedy is not None
    assert bool(fault.text.fault_code) == (level is not Level.UNKNOWN)


def test_axes_of_other_controllers_need_no_pins():
    facts = replace(HEALTHY, pins=False, gpio=None, realtime=None)
    alone = replace(facts, groups=replace(GROUPS, member=frozenset({"spi"})))
    for found in (findings(None, facts), findings(None, alone)):
        assert exit_status(found) == GOOD
        assert [one.level for one in found if one.check in ("gpio", "realtime")] == [Level.NOTE]


@each_case(
    "host, words",
    [
        ("robot", "from one installation. Run: sudo systemctl restart gpr20-robot."),
        ("laptop", "install the same version on all its computers"),
    ],
)
def test_a_robot_that_was_not_restarted_after_an_update_is_found(host, words):
    assert exit_status(findings(facts(), replace(HEALTHY, software=SAME))) == GOOD
    updated = replace(SAME, revision="new", host=host)
    machine = replace(HEALTHY, software=updated, place=SERVED)
    (found, *_others) = findings(facts(), machine)
    assert found.level is Level.WARNING
    assert "runs the software 0.1.0 (abc), but 0.1.0 (new) is installed" in str(found.text)
    assert words in str(found.remedy)


def test_another_data_folder_is_listed_once_and_its_space_is_not_called_good():
    facts_of_both = replace(HEALTHY, disk=replace(DISK, known=OTHER), configuration=(OTHER,))
    found = findings(None, facts_of_both)
    assert [one.check for one in found if one.level is Level.FAULT] == ["data_folder"]
    assert not {"data_disk", "disk_speed"} & {one.check for one in found}
    # Free space is listed once.
    texts = [str(one.text) for one in findings(facts(), HEALTHY)]
    assert sum("GB free" in one for one in texts) == 1


CHANGES = [one[0] for one in CASES]
CHANGES += [{name: None} for name in OPTIONAL]
CHANGES += [{"hardware": use, "two_computers": False, "closed": True} for use in HardwareUse]
CHANGES += [{"place": SERVED}, {"disk": replace(DISK, trace_s=GONE)}]
MACHINES = st.lists(st.sampled_from(CHANGES), max_size=30).map(
    lambda some: replace(HEALTHY, **dict(ChainMap(*some)))
)


@given(st.none() | ROBOTS, MACHINES)
def test_whatever_is_known_every_finding_has_a_sentence_and_a_remedy(robot, machine):
    for some in (machine, None):
        found = findings(robot, some)
        assert found or robot is some is None
        for one in found:
            assert one.check and str(one.text)
            assert one.level < Level.UNKNOWN or str(one.remedy)
            assert one.level < Level.WARNING or one.text.fault_code
        if robot is not None and exit_status(found) == GOOD:
            assert robot.master_alive and robot.control_alive
            assert robot.configured and robot.configuration_problem is None


@given(MACHINES)
def test_what_is_not_known_is_never_called_good(machine):
    found = {one.check: one.level for one in findings(None, machine)}
    looked_at = {
        "addresses": machine.addresses,
        "temperature": machine.temperature_c,
        "power": machine.power,
        "data_disk": machine.disk,
        "firewall": machine.outside,
        "memory": machine.memory,
        "volumes": machine.volumes,
        "config_files": machine.configuration,
        "vna_port": machine.vna,
    }
    for check, fact in looked_at.items():
        assert not isinstance(fact, Unknown) or found[check] is Level.UNKNOWN
    if machine.hardware is HardwareUse.NEEDED:
        for check in ("groups", "spi", "gpio", "realtime"):
            fact = getattr(machine, check)
            known = fact is not None and not isinstance(fact, Unknown)
            assert known or found[check] is Level.UNKNOWN
