"""Checks of a computer that drives pins and bus of the robot, and of its supply."""

from __future__ import annotations

import getpass
import importlib.util
import os
from pathlib import Path
from typing import Iterator, Mapping

from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_doctor import faults
from gpr20_doctor.low.programs import answer_of
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import axis_node
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import HEIGHT_SENSOR

FIRMWARE = ("vcgencmd", "get_throttled")
# Bits of its answer: low voltage now and before, slowed down now.
LOW_NOW, SLOW_NOW, LOW_BEFORE = 1 << 0, 1 << 2, 1 << 16
GPIO_FILES = ("dev/gpiomem", "dev/gpiochip*")
# The library of the pins.
PIN_MODULE = "RPi.GPIO"


def check_hardware(machine: Machine) -> Iterator[Finding]:
    """Judge everything that the drivers of axes and height sensor need."""
    if not machine.drives_hardware:
        return
    yield _spi(machine)
    if any(_has_pins(machine, axis) for axis in AxisId):
        yield _gpio(machine.root)


def _has_pins(machine: Machine, axis: AxisId) -> bool:
    """Return whether an axis is moved by pins, and not by another controller."""
    node = machine.nodes.get(axis_node(axis))
    own = machine.configured("axes.yaml", axis.value) if node is None else node.configuration
    return not (isinstance(own, Mapping) and own.get("controller"))


def _spi(machine: Machine) -> Finding:
    bus, device = (
        machine.value(HEIGHT_SENSOR, "height.yaml", key) or 0 for key in ("spi_bus", "spi_device")
    )
    path = machine.root / f"dev/spidev{bus}.{device}"
    if not path.exists():
        text = Message("The SPI bus is off: there is no {path}.", path=str(path))
        advice = Message("Run: sudo raspi-config nonint do_spi 0. Then restart the computer.")
        return Finding.of("spi", text, NOT_SET_UP, advice=advice)
    if not _usable(path):
        text = Message("The SPI bus {path} cannot be read and written.", path=str(path))
        return Finding.of("spi", text, NOT_SET_UP, advice=_join("spi"))
    return Finding.of("spi", Message("SPI bus {path}", path=str(path)))


def _gpio(root: Path) -> Finding:
    devices = [path for pattern in GPIO_FILES for path in sorted(root.glob(pattern))]
    if importlib.util.find_spec(PIN_MODULE.split(".")[0]) is None:
        text = Message("The library {library} for the pins is not installed.", library=PIN_MODULE)
        advice = Message("Run: scripts/setup.sh --robot")
        return Finding.of("gpio", text, NOT_SET_UP, advice=advice)
    if not any(map(_usable, devices)):
        text = Message("The pins cannot be used: no access to /dev/gpiomem or /dev/gpiochip.")
        return Finding.of("gpio", text, NOT_SET_UP, advice=_join("gpio"))
    return Finding.of("gpio", Message("The pins can be used."))


def _usable(path: Path) -> bool:
    return os.access(str(path), os.R_OK | os.W_OK)


def _join(group: str) -> Message:
    values = {"group": group, "user": getpass.getuser()}
    return Message("Run: sudo usermod -aG {group} {user}. Then log out and in.", **values)


def check_power(machine: Machine) -> Iterator[Finding]:
    """Judge the supply of a Raspberry Pi, as its firmware says."""
    if not machine.is_pi:
        return
    bits = int(answer_of(FIRMWARE).split("=")[-1], 16)
    if bits & LOW_NOW:
        text = Message("The supply voltage of the Raspberry Pi is too low now.")
        yield Finding.of("power", text, faults.VOLTAGE_LOW)
    elif bits & (SLOW_NOW | LOW_BEFORE):
        text = Message(
            "The supply voltage of the Raspberry Pi was too low since its start, or it was "
            "slowed down."
        )
        yield Finding.of("power", text, faults.VOLTAGE_LOW, mild=True)
    else:
        yield Finding.of("power", Message("Supply voltage of the Raspberry Pi"))
