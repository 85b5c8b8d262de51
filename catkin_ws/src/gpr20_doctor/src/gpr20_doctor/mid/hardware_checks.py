"""Checks of a computer that drives pins and bus of the robot."""

from __future__ import annotations

from typing import Dict, Iterator, Sequence

from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_doctor.low.pi import PIN_MODULE, DeviceFile, Groups, Pins, Realtime
from gpr20_doctor.mid.finding import Finding, Level, not_known
from gpr20_doctor.mid.machine_facts import HardwareUse, MachineFacts
from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY

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
