"""The pins of the whole robot: what uses each, and whether that goes together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Tuple

from gpr20_common.message import Message
from gpr20_launch.mid.pin_table import EEPROM, GPIO_OF_BOARD, I2C, SPI_BUSES, UART
from gpr20_launch.mid.problem import Problem, problem
from gpr20_launch.mid.robot_files import AXES_FILE, Reading
from gpr20_survey.axes.axis_parameters import AxisParameters, Level, Pull

HEIGHT_FILE = "height.yaml"
# What enables the drivers of several axes.
SHARED = "enable_pin"
# A switch to ground works with the resistors of I2C.
ENDSTOP = "sensor_pin"
_EEPROM = Message("at every start the Raspberry Pi sends pulses to this pin, looking for an EEPROM")
_CONSOLE = Message("this is the serial port, whose console Linux prints on unless it is off")
_CE1 = Message("this is CE1 of SPI0, which Linux drives unless only one chip select is set up")
RESERVED: Mapping[int, Message] = {
    **dict.fromkeys(EEPROM, _EEPROM),
    **dict.fromkeys(UART, _CONSOLE),
    **dict.fromkeys(I2C, Message("this is I2C, with a resistor of 1.8 kOhm to 3.3 V")),
    SPI_BUSES[0].pins(1)["CE1"]: _CE1,
}


@dataclass(frozen=True)
class PinUse:
    """One use of a pin.

    Attributes:
        pin: The pin [BOARD].
        file: File that names it.
        key: Key that names it.
        text: The use, for people.
        value: Value of the key.
        shared: Uses that have the same text here may share the pin; empty: this may not.
    """

    pin: int
    file: Path
    key: str
    text: str
    value: object
    shared: str = ""


def check_pins(reading: Reading) -> Iterator[Problem]:
    """Find pins with two purposes, and pins that something beside this software uses."""
    lines, without = _spi(reading)
    uses = [*_axis_uses(reading), *lines]
    yield from _shared(uses)
    for use in uses:
        yield from _reserved(use)
    axes = {axis: one for axis, one in reading.axes().items() if not one.controller}
    for axis, parameters in axes.items():
        yield from _pull(reading.folder / AXES_FILE, axis, parameters)
    yield from without


def is_pin(key: str, value: Any) -> bool:
    """Return whether a key of an axis has a pin that exists."""
    return key.endswith("_pin") and type(value) is int and value in GPIO_OF_BOARD


def _axis_uses(reading: Reading) -> Iterator[PinUse]:
    for axis, values in reading.raw_axes.items():
        if values.get("controller") or not reading.knows(AXES_FILE, f"{axis}/controller"):
            continue  # that has no pins
        level = values.get("enable_active", Level.LOW.value)
        known = reading.knows(AXES_FILE, f"{axis}/enable_active")
        for name, pin in values.items():
            if is_pin(name, pin) and (known or name != SHARED):
                key = f"{axis}/{name}"
                default = "" if (AXES_FILE, key) in reading.given else " (default)"
                shared = f"{name} {level}" if name == SHARED else ""
                yield PinUse(
                    pin, reading.folder / AXES_FILE, key, f"{AXES_FILE} {key}{default}", pin, shared
                )


def _spi(reading: Reading) -> Tuple[List[PinUse], List[Problem]]:
    """Return the lines of the height sensor, or that there are none."""
    if not reading.knows(HEIGHT_FILE, "spi_bus", "spi_device"):
        return [], []
    sensor, file = reading.record("height_sensor"), reading.folder / HEIGHT_FILE
    bus, device = sensor.spi_bus, sensor.spi_device
    lines = SPI_BUSES.get(bus)
    if lines is None:
        reason = Message("the header of a Raspberry Pi 4 has no such bus")
        allowed = ", ".join(map(str, SPI_BUSES))
        return [], [problem(file, "spi_bus", bus, reason, allowed)]
    if device >= len(lines.selects):
        reason = Message("SPI bus {bus} has no such chip select", bus=bus)
        allowed = f"0 - {len(lines.selects) - 1}"
        return [], [problem(file, "spi_device", device, reason, allowed)]
    uses = []
    for name, pin in lines.pins(device).items():
        key, value = ("spi_device", device) if name.startswith("CE") else ("spi_bus", bus)
        uses.append(PinUse(pin, file, key, f"{HEIGHT_FILE} {key}: SPI{bus} {name}", value))
    return uses, []


def _shared(uses: List[PinUse]) -> Iterator[Problem]:
    by_pin: Dict[int, List[PinUse]] = {}
    for use in uses:
        by_pin.setdefault(use.pin, []).append(use)
    for pin, own in by_pin.items():
        first = own[0]
        if len(own) == 1 or (first.shared and {one.shared for one in own} == {first.shared}):
            continue
        texts, last, gpio = tuple(one.text for one in own), own[-1], GPIO_OF_BOARD[pin]
        values = {"pin": pin, "gpio": gpio, "count": len(own), "uses": ", ".join(texts)}
        reason = Message(
            "pin {pin} (GPIO{gpio}) has {count} purposes: {uses}; find out with a continuity meter "
            "where it leads, as docs/wiring.md describes",
            **values,
        )
        allowed = Message(
            "a pin of its own for each; axes can share only {shared}, with the same {level}",
            shared=SHARED,
            level="enable_active",
        )
        yield problem(last.file, last.key, last.value, reason, allowed, uses=texts)


def _reserved(use: PinUse) -> Iterator[Problem]:
    reason = RESERVED.get(use.pin)
    of_axis = use.file.name == AXES_FILE
    if reason is None or not of_axis or (use.pin in I2C and use.key.endswith(ENDSTOP)):
        return
    free = ", ".join(map(str, sorted(set(GPIO_OF_BOARD) - {*RESERVED, 19, 21, 23, 24})))
    allowed = Message("another pin, with the signal connected to it: {free}", free=free)
    yield problem(use.file, use.key, use.value, reason, allowed, use.pin not in EEPROM)


def _pull(file: Path, axis: str, parameters: AxisParameters) -> Iterator[Problem]:
    pin, pull, up = parameters.sensor_pin, parameters.endstop_pull, Pull.UP.value
    if pin in I2C and pull != up:
        reason = Message(
            "pin {pin} has a resistor of 1.8 kOhm to 3.3 V, which pulls up; measure the signal, "
            "pressed and free, and correct {active}, too",
            pin=pin,
            active="endstop_active",
        )
        yield problem(file, f"{axis}/endstop_pull", pull, reason, up)
