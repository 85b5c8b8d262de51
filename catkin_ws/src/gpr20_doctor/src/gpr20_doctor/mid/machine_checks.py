"""Checks of the computer on which the doctor runs.

Each check is a function from the facts to findings. To add one, write it and list it in CHECKS.
"""

from __future__ import annotations

import math
from typing import Callable, Iterable, Iterator, Tuple

from gpr20_common.faults import DISK_SLOW, INTERNAL, OVERLOADED
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.low.pi import Power
from gpr20_doctor.low.programs import Tracking
from gpr20_doctor.mid.finding import Finding, Level, Unknown, not_known
from gpr20_doctor.mid.machine_facts import AddressFacts, DiskFacts, MachineFacts, PortFacts
from gpr20_doctor.mid.place import Place
from gpr20_doctor.mid.robot_checks import CHECK_LINK, disk_space
from gpr20_doctor.mid.system_checks import (
    check_configuration,
    check_date,
    check_firewall,
    check_hardware,
    check_memory,
    check_volumes,
)
from gpr20_survey.faults import CLOCK_WRONG, VNA_SILENT

BYTES_PER_GB = 1e9
WARM_C = 70.0
# A Raspberry Pi slows its processor down at this temperature.
HOT_C = 80.0
# States of a process that does nothing (proc(5)): stopped, traced, ended.
HALTED = frozenset("TtZX")
# Storing runs beside the next sample, which takes longer than this [s].
TRACE_LIMIT_S = 1.0
CLOCK_LIMIT_S = 0.1
AS_SERVICES = Message("Run it as the services do: gpr20-run doctor")
FIRST_USE = Message(
    "If the surveys have a disk of their own, mount it. Then start the robot, which marks the "
    "folder, and run gpr20 doctor again."
)

Check = Callable[[MachineFacts], Iterable[Finding]]


def check_addresses(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the addresses of the two machines, and where ROS listens."""
    addresses = facts.addresses
    if not isinstance(addresses, AddressFacts):
        yield not_known("addresses", Message("the addresses of this computer"), addresses)
        return
    two = addresses.robot or addresses.server
    judge = _two_machines if two else _one_machine
    yield judge(addresses, facts.place)
    gone = [one for one in addresses.foreign if one != addresses.ros_address]
    if gone:
        text = Message(
            "Parts of the robot on this computer listen on {addresses}, which it does not have: "
            "they cannot be reached.",
            addresses=", ".join(gone),
        )
        yield Finding.of("addresses", text, faults.ADDRESS, advice=CHECK_LINK, restart="")


def check_launch(facts: MachineFacts) -> Iterator[Finding]:
    """Find parts of the robot that nobody would start again."""
    if facts.left_over:
        text = Message(
            "The launch of {count} parts of the robot on this computer has ended. They run on, "
            "and nothing starts one of them again if it ends.",
            count=len(facts.left_over),
        )
        advice = Message(
            "Run: kill {numbers}. A survey that runs is stopped and can be resumed. Then start the "
            "robot again.",
            numbers=" ".join(map(str, sorted(facts.left_over))),
        )
        yield Finding.of("launch", text, INTERNAL, mild=True, advice=advice, restart="")


def check_watchdog(facts: MachineFacts) -> Iterator[Finding]:
    """Judge what would end the parts of the robot that hang."""
    name = Message("Watchdog")
    if HALTED.intersection(facts.watchdogs):
        text = Message("{name} hangs: it runs, but does not answer.", name=name)
        yield Finding.of("watchdog", text, INTERNAL)
    elif "" in facts.watchdogs:
        text = Message("No watchdog runs here: a part of the robot that hangs is not restarted.")
        yield Finding("watchdog", Level.UNKNOWN, text, INTERNAL.remedy)
    elif facts.watchdogs:
        yield Finding.of("watchdog", name)


def check_temperature(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the temperature of the processor."""
    temperature_c = facts.temperature_c
    if temperature_c is None:
        text = Message("Temperature of the processor: not measured here.")
        yield Finding("temperature", Level.NOTE, text)
        return
    if isinstance(temperature_c, Unknown) or not math.isfinite(temperature_c):
        yield not_known("temperature", Message("the processor's temperature"), temperature_c)
        return
    text = Message("Temperature of the processor: {celsius:.0f} °C", celsius=temperature_c)
    fault = OVERLOADED if temperature_c >= WARM_C else None
    advice = Message("Shade the computer and check its fan.")
    yield Finding.of("temperature", text, fault, mild=temperature_c < HOT_C, advice=advice)


def check_power(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the supply of a Raspberry Pi."""
    power = facts.power
    if power is None:
        yield Finding("power", Level.NOTE, Message("Supply voltage: not measured here."))
    elif not isinstance(power, Power):
        yield not_known("power", Message("the supply voltage"), power)
    elif power.low_now:
        text = Message("The supply voltage of the Raspberry Pi is too low now.")
        yield Finding.of("power", text, faults.VOLTAGE_LOW)
    elif power.low_before:
        text = Message(
            "The supply voltage of the Raspberry Pi was too low since its start, or it was "
            "slowed down."
        )
        yield Finding.of("power", text, faults.VOLTAGE_LOW, mild=True)
    else:
        yield Finding.of("power", Message("Supply voltage of the Raspberry Pi"))


def check_disk(facts: MachineFacts) -> Iterator[Finding]:
    """Judge the folder of the surveys, its disk and the speed of that."""
    disk = facts.disk
    if disk is None:
        text = Message("Disk of the surveys: not on this computer.")
        yield Finding("data_disk", Level.NOTE, text)
        return
    if not isinstance(disk, DiskFacts):
        yield not_known("data_disk", Message("the disk of the surveys"), disk)
        return
    yield _data_folder(disk)
    if isinstance(disk.known, Message):
        return  # what is there now is not the disk of the surveys
    yield disk_space("data_disk", disk.free_bytes / BYTES_PER_GB)
    if disk.trace_s is not None:
        yield _disk_speed(disk.trace_s)


def check_clock(facts: MachineFacts) -> Iterator[Finding]:
    """Judge what chrony says."""
    clock = facts.clock
    if not facts.two_computers:
        yield Finding("clock", Level.NOTE, Message("Clock offset: there is one computer."))
    elif not isinstance(clock, Tracking):
        remedy = Message("Install chrony on both computers, or run: chronyc tracking")
        yield not_known("clock", Message("the offset of the clock"), clock, remedy)
    elif not clock.synchronized:
        text = Message("chrony does not follow the other computer's clock.")
        advice = Message("Run: chronyc sources. Check the cable between the computers.")
        yield Finding.of("clock", text, CLOCK_WRONG, mild=True, advice=advice)
    elif abs(clock.offset_s) > CLOCK_LIMIT_S:
        text = Message("This clock is off by {offset_s:.3f} s.", offset_s=clock.offset_s)
        advice = Message("Wait a while. If it stays and no survey runs, run: sudo chronyc makestep")
        yield Finding.of("clock", text, CLOCK_WRONG, mild=True, advice=advice)
    else:
        text = Message("Clock: off by {offset_ms:.2f} ms", offset_ms=1e3 * clock.offset_s)
        yield Finding.of("clock", text)


def check_vna_port(facts: MachineFacts) -> Iterator[Finding]:
    """Judge whether the VNA can be reached from here."""
    vna = facts.vna
    if vna is None:
        text = Message("Network of the VNA: not checked now.")
        yield Finding("vna_port", Level.NOTE, text)
    elif not isinstance(vna, PortFacts):
        file = printable(facts.place.config / "analyzer.yaml")
        remedy = Message("Write the address of the VNA into {file}.", file=file)
        yield not_known("vna_port", Message("the network of the VNA"), vna, remedy)
    elif vna.failure is not None:
        text = Message(
            "The VNA at {address} cannot be reached: {reason}",
            address=vna.address,
            reason=vna.failure,
            details=f"TCP port {vna.port}",
        )
        yield Finding.of("vna_port", text, VNA_SILENT)
    else:
        text = Message("The VNA at {address} can be reached.", address=vna.address)
        yield Finding.of("vna_port", text)


def _one_machine(addresses: AddressFacts, place: Place) -> Finding:
    address = addresses.ros_address
    if address == "localhost" or address.startswith("127."):
        return Finding.of("addresses", Message("One computer: ROS listens on loopback."))
    advice = AS_SERVICES if place.settings else None
    if address in addresses.foreign:
        text = Message(
            "ROS_IP or ROS_HOSTNAME is {address}, which is no address of this computer: what is "
            "started here cannot be reached.",
            address=address,
        )
        return Finding.of("addresses", text, faults.ADDRESS, advice=advice)
    text = Message(
        "ROS listens on {address}: everybody in the network can move the robot.",
        address=address or "*",
    )
    return Finding.of("addresses", text, faults.ADDRESS, mild=True, advice=advice)


def _two_machines(addresses: AddressFacts, place: Place) -> Finding:
    configured = f"{addresses.robot or '?'}, {addresses.server or '?'}"
    if not addresses.own:
        text = Message(
            "This computer has none of the addresses {configured}.", configured=configured
        )
        restart = Message(
            "Check the link, and GPR20_ROBOT and GPR20_SERVER in {where}. Then run: sudo "
            "systemctl restart gpr20-firewall",
            where=printable(place.settings or ""),
        )
        advice = restart if place.settings else None
        return Finding.of("addresses", text, faults.ADDRESS, advice=advice)
    if addresses.ros_address not in addresses.own:
        text = Message(
            "ROS listens on {address}, but this computer is {own}.",
            address=addresses.ros_address or "*",
            own=addresses.own[0],
        )
        advice = AS_SERVICES if place.settings else None
        return Finding.of("addresses", text, faults.ADDRESS, advice=advice)
    text = Message("Two computers: this one is {own}.", own=addresses.own[0])
    return Finding.of("addresses", text)


def _data_folder(disk: DiskFacts) -> Finding:
    known, folder = disk.known, printable(disk.folder)
    if isinstance(known, Message):
        return Finding.of_fault("data_folder", known)
    if isinstance(known, Unknown) or not known.identity:
        fact = known if isinstance(known, Unknown) else Unknown(Message("it was never used here"))
        subject = Message("whether {folder} is the right data folder", folder=folder)
        return not_known("data_folder", subject, fact, FIRST_USE)
    if known.remembered:
        text = Message(
            "Data folder {folder}, identity {identity}", folder=folder, identity=known.identity
        )
        return Finding.of("data_folder", text)
    text = Message(
        "Data folder {folder}, identity {identity}; this user has not stored a survey in it.",
        folder=folder,
        identity=known.identity,
    )
    return Finding("data_folder", Level.NOTE, text)


def _disk_speed(trace_s: object) -> Finding:
    if not isinstance(trace_s, float):
        return not_known("disk_speed", Message("the speed of the disk"), trace_s)
    if math.isinf(trace_s):
        text = Message("The disk did not store a large trace in time.")
        return Finding.of("disk_speed", text, DISK_SLOW)
    text = Message(
        "Disk: a large trace is stored in {trace_s:.2f} s; a survey needs {limit_s:g} s or less",
        trace_s=trace_s,
        limit_s=TRACE_LIMIT_S,
    )
    fault = DISK_SLOW if trace_s > TRACE_LIMIT_S else None
    return Finding.of("disk_speed", text, fault, mild=True)


CHECKS: Tuple[Check, ...] = (
    check_configuration,
    check_launch,
    check_watchdog,
    check_addresses,
    check_firewall,
    check_hardware,
    check_temperature,
    check_power,
    check_memory,
    check_volumes,
    check_disk,
    check_date,
    check_clock,
    check_vna_port,
)
