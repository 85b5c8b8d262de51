"""Checks of what the whole computer needs, and of one that drives pins and bus of the robot.

Each check is a function from the facts to findings, as in `machine_checks`, which lists them.
"""

from __future__ import annotations

from typing import Dict, Iterator, Sequence

from gpr20_common.faults import CONFIGURATION, DISK_FULL, DISK_REFUSES, NOT_SET_UP, OVERLOADED
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.low.pi import PIN_MODULE, DeviceFile, Groups, Pins, Realtime
from gpr20_doctor.low.system import Memory
from gpr20_doctor.mid.finding import Finding, Level, not_known
from gpr20_doctor.mid.machine_facts import HardwareUse, MachineFacts, OutsideFacts, VolumeFacts
from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY
from gpr20_survey.faults import CLOCK_WRONG

MB, GB = 1e6, 1e9
# Below them the system begins to end programs [bytes].
LOW_MEMORY, NO_MEMORY = 200e6, 80e6
# Logs of a day; below the second, programs fail when they write [bytes].
LOW_SPACE, NO_SPACE = 200e6, 20e6
FEW_FILES = 2000
# A clock that starts at the last date that it knows is days behind; a time zone is not.
BEHIND_LIMIT_S = 86400.0
LISTED = 4
CHECK = "rosrun gpr20_launch robot_config check"
AS_ROOT = 'sudo -E env "PATH=$PATH" rosrun gpr20_doctor doctor'


def check_configuration(facts: MachineFacts) -> Iterator[Finding]:
    """Say what the check of the whole robot found in the files on this computer."""
    found = facts.configuration
    if found is None:
        return  # a launch has checked it already
    folder = printable(facts.place.config)
    if not isinstance(found, tuple):
        subject = Message("whether the configuration in {folder} is correct", folder=folder)
        own = "gpr20-run config check" if facts.place.settings else f"{CHECK} {folder}"
        command = Message("Run: {command}", command=own)
        yield not_known("config_files", subject, found, command)
    elif not found:
        values = {"folder": folder, "robot": facts.files}
        text = Message("Configuration in {folder}, for robot:={robot}", **values)
        yield Finding.of("config_files", text)
    else:
        for reason in found:
            # Each problem has its own fault; one without has that of a value.
            text = Message("Configuration: {reason}", reason=reason)
            known = text if text.cause is not None else text.with_fault(CONFIGURATION)
            yield Finding.of_fault("config_files", known)


def check_firewall(facts: MachineFacts) -> Iterator[Finding]:
    """Judge what a computer with a foreign address reaches here."""
    outside = facts.outside
    if outside is None and facts.closed:
        text = Message("Firewall: not needed, nothing of ROS is open to other computers.")
        yield Finding("firewall", Level.NOTE, text)
    elif outside is None:
        yield not_known("firewall", Message("where ROS listens"), None)
    elif not isinstance(outside, OutsideFacts):
        subject = Message("whether a foreign computer reaches the robot's ports")
        as_root = "sudo gpr20-run doctor" if facts.place.settings else AS_ROOT
        command = Message("Run the doctor once as root: {command}", command=as_root)
        yield not_known("firewall", subject, outside, command)
    elif not outside.reached:
        text = Message("Foreign computers are kept out: {tried} ports tried", tried=outside.tried)
        yield Finding.of("firewall", text)
    else:
        text = Message(
            "A computer with a foreign address reaches ports of this one ({ports}): everybody in "
            "the network can move the robot.",
            ports=", ".join(map(str, outside.reached[:LISTED])),
        )
        advice, program = None, printable(facts.place.firewall)
        if facts.place.settings and outside.switched_off:
            advice = Message(
                "Write GPR20_FIREWALL=on into {where}. Run: sudo {program} load",
                where=printable(facts.place.settings),
                program=program,
            )
        elif facts.place.settings:
            advice = Message("Run: sudo {program} load", program=program)
        yield Finding.of("firewall", text, faults.FIREWALL, advice=advice)


def check_memory(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the memory that programs may still have."""
    memory = facts.memory
    if memory is None:
        return
    if not isinstance(memory, Memory):
        yield not_known("memory", Message("the free memory"), memory)
        return
    free = memory.available_bytes
    text = Message("Memory: {free_mb:.0f} MB free", free_mb=free / MB)
    fault = OVERLOADED if free < LOW_MEMORY else None
    advice = Message(
        "End other programs on this computer; to see them, run: ps aux --sort=-rss | head"
    )
    if fault is None and memory.ended_programs:
        text = Message(
            "Linux has ended {count} programs for lack of memory since the start.",
            count=memory.ended_programs,
        )
        fault = OVERLOADED
        advice = Message(
            "Note which program was ended: sudo dmesg | grep -i oom. Then restart the computer, "
            "and run nothing else beside the robot."
        )
    yield Finding.of("memory", text, fault, mild=free >= NO_MEMORY, advice=advice)


def check_volumes(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the file systems that the robot writes to."""
    volumes = facts.volumes
    if volumes is None:
        return
    if not isinstance(volumes, tuple):
        yield not_known("volumes", Message("the file systems"), volumes)
        return
    bad = [one for volume in volumes for one in _volume(volume)]
    yield from bad
    if not bad:
        points = ", ".join(printable(one.mount_point) for one in volumes)
        text = Message("File systems that can be written: {points}", points=points)
        yield Finding.of("volumes", text)


def _volume(volume: VolumeFacts) -> Iterator[Finding]:
    names = {"point": printable(volume.mount_point), "folder": printable(volume.folder)}
    if volume.read_only:
        text = Message("The file system {point} is read-only; {folder} is on it.", **names)
        advice = Message(
            "Copy what must not be lost from {point}. Then run: sudo mount -o remount,rw {point}. "
            "If that fails or it happens again, replace the card or disk.",
            **names,
        )
        yield Finding.of("volumes", text, DISK_REFUSES, advice=advice)
        return
    advice = Message(
        "Make space on {point}, but copy surveys before you delete them. To see what is large, "
        "run: sudo du -xh {point} | sort -h | tail",
        **names,
    )
    if volume.free_bytes < LOW_SPACE:
        text = Message(
            "The file system {point} has {free_mb:.0f} MB left; {folder} is on it.",
            free_mb=volume.free_bytes / MB,
            **names,
        )
        mild = volume.free_bytes >= NO_SPACE
        yield Finding.of("volumes", text, DISK_FULL, mild, advice)
    if volume.free_files is not None and volume.free_files < FEW_FILES:
        text = Message(
            "The file system {point} can hold only {count} more files; {folder} is on it.",
            count=volume.free_files,
            **names,
        )
        yield Finding.of("volumes", text, DISK_FULL, advice=advice)


def check_date(facts: MachineFacts) -> Iterator[Finding]:
    """Find a clock that cannot be right."""
    if facts.behind_s > BEHIND_LIMIT_S:
        text = Message(
            "This computer's clock is {days:.0f} days before the date of the installed software.",
            days=facts.behind_s / 86400.0,
        )
        advice = Message("Unless a survey runs, set the clock: sudo date -s '2026-07-31 14:00'")
        yield Finding.of("date", text, CLOCK_WRONG, mild=True, advice=advice)


SPI = "spi"
GROUPS = ("gpio", SPI)
JOIN_GROUPS = Message("Add the user to the groups gpio and spi, then log out and in.")
# Each axis locks its memory, some 30 MB.
LOCKED_BYTES = 100_000_000
SKIPPED: Dict[HardwareUse, Message] = {
    HardwareUse.SIMULATED: Message(
        "Groups, SPI, GPIO, real-time limits: not needed, the robot is simulated."
    ),
    HardwareUse.ELSEWHERE: Message(
        "Groups, SPI, GPIO, real-time limits: not needed on this computer."
    ),
    HardwareUse.NO_PI: Message(
        "Groups, SPI, GPIO, real-time limits: not checked, this is not a Raspberry Pi."
    ),
}


def check_hardware(facts: MachineFacts) -> Iterator[Finding]:
    """Judge everything that the drivers of axes and height sensor need."""
    if facts.hardware is not HardwareUse.NEEDED:
        yield Finding("hardware", Level.NOTE, SKIPPED[facts.hardware])
        return
    needed = GROUPS if facts.pins else (SPI,)
    yield from _groups(facts.groups, needed, facts.place.settings is not None)
    yield _spi(facts.spi)
    if not facts.pins:
        text = Message("GPIO, real-time limits: not needed, other controllers move the axes.")
        yield Finding("gpio", Level.NOTE, text)
        return
    yield _gpio(facts.gpio)
    yield _realtime(facts.realtime)


def _groups(groups: object, needed: Sequence[str], packages: bool) -> Iterator[Finding]:
    if not isinstance(groups, Groups):
        yield not_known("groups", Message("the user's groups"), groups)
        return
    if groups.is_root:
        yield Finding.of("groups", Message("Groups: not needed by the user root"))
        return
    missing = [one for one in needed if one not in groups.member]
    if not missing:
        values = {"user": groups.user, "groups": ", ".join(needed)}
        yield Finding.of("groups", Message("Groups of {user}: {groups}", **values))
    for name in missing:
        yield _missing_group(groups, name, packages)


def _missing_group(groups: Groups, name: str, packages: bool) -> Finding:
    values = {"user": groups.user, "group": name}
    if name not in groups.existing:
        text = Message("This computer has no group {group}.", **values)
        advice = Message(
            "Run: sudo groupadd --system {group}. Then restart the computer.", **values
        )
        if packages:
            advice = Message(
                "Run: sudo apt install --reinstall gpr20-robot. Then restart the computer."
            )
    elif name in groups.listed:
        text = Message("{user} is in the group {group} from the next login on.", **values)
        advice = Message("Log out and in, or restart.")
    else:
        text = Message("{user} is not in the group {group}.", **values)
        advice = Message("Run: sudo usermod -aG {group} {user}. Then log out and in.", **values)
    return Finding.of("groups", text, NOT_SET_UP, mild=True, advice=advice)


def _spi(device: object) -> Finding:
    if not isinstance(device, DeviceFile):
        return not_known("spi", Message("the SPI bus"), device)
    path = str(device.path)
    if device.usable:
        return Finding.of("spi", Message("SPI bus {path}", path=path))
    if device.exists:
        text = Message("The SPI bus {path} cannot be read and written.", path=path)
        return Finding.of("spi", text, NOT_SET_UP, advice=JOIN_GROUPS)
    text = Message("The SPI bus is off: there is no {path}.", path=path)
    advice = Message("Run: sudo raspi-config nonint do_spi 0. Then restart the computer.")
    return Finding.of("spi", text, NOT_SET_UP, advice=advice)


def _gpio(gpio: object) -> Finding:
    if not isinstance(gpio, Pins):
        return not_known("gpio", Message("access to the pins"), gpio)
    usable = [str(one.path) for one in gpio.devices if one.usable]
    if not gpio.library:
        text = Message("The library {library} for the pins is not installed.", library=PIN_MODULE)
        advice = Message("Run: scripts/setup.sh --robot")
    elif usable:
        return Finding.of("gpio", Message("Pins: {path} can be used", path=usable[0]))
    else:
        text = Message("The pins cannot be used: no access to /dev/gpiomem or /dev/gpiochip.")
        advice = JOIN_GROUPS
    return Finding.of("gpio", text, NOT_SET_UP, advice=advice)


def _realtime(limits: object) -> Finding:
    if not isinstance(limits, Realtime):
        return not_known("realtime", Message("the real-time limits"), limits)
    if not limits.granted:
        text = Message(
            "Real-time priority {needed} is refused; allowed is {allowed}. Pulses can be late.",
            needed=PULSE_PRIORITY,
            allowed=limits.priority,
        )
    elif limits.locked_bytes is not None and limits.locked_bytes < LOCKED_BYTES:
        text = Message(
            "Only {locked_mb:.0f} MB of memory can be locked. Pulses can be late.",
            locked_mb=limits.locked_bytes / 1e6,
        )
    else:
        return Finding.of("realtime", Message("Real-time priority and locked memory"))
    advice = Message("Allow rtprio and memlock in /etc/security/limits.d, then log out and in.")
    return Finding.of("realtime", text, NOT_SET_UP, mild=True, advice=advice)
