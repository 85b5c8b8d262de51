"""The pins of the whole robot: what uses each, and whether that goes together."""

from __future__ import annotations

from typing import Dict, Iterator, List, NamedTuple

from gpr20_launch.mid.pin_table import (
    EEPROM,
    FREE,
    GPIO_OF_BOARD,
    I2C,
    NOT_GPIO,
    RESERVED,
    SPI_BUSES,
    spi_pins,
)
from gpr20_launch.mid.robot_files import AXES_FILE, AXIS_SECTIONS, Problem, Reading, problem
from gpr20_survey.axes.axis_parameters import Level, Pull

HEIGHT_FILE = "height.yaml"
# What enables the drivers of several axes.
SHARED = "enable_pin"


class PinUse(NamedTuple):
    """One use of a pin [BOARD]: file, key and its value; what is said of it; and with whom.

    Uses with the same text in `shared` may share the pin; with none, this may not.
    """

    pin: int
    file: str
    key: str
    value: object
    text: str
    shared: str = ""


def check_pins(reading: Reading) -> Iterator[Problem]:
    """Find pins with two purposes, and pins that something beside this software uses."""
    uses = list(_axis_uses(reading))
    allowed = f"another pin, with the signal connected to it: {', '.join(map(str, FREE))}"
    for use in uses:
        where = (reading.folder / use.file, use.key, use.value)
        if use.pin not in GPIO_OF_BOARD:
            known = NOT_GPIO.get(use.pin, "no pin")
            reason = f"pin {use.pin} is {known}; pins have the numbers of the header, BOARD"
            yield problem(*where, reason, allowed)
        # A switch to ground works with the resistors of I2C.
        elif use.pin in RESERVED and not (use.pin in I2C and use.key.endswith("/sensor_pin")):
            yield problem(*where, RESERVED[use.pin], allowed, doubtful=use.pin not in EEPROM)
    yield from _spi(reading, uses)
    yield from _shared(reading, uses)
    for axis, own in reading.axes().items():
        if own.sensor_pin in I2C and not own.controller and own.endstop_pull != Pull.UP.value:
            reason = (
                f"pin {own.sensor_pin} has a resistor of 1.8 kOhm to 3.3 V, which pulls up; "
                "measure the signal, pressed and free, and correct endstop_active, too"
            )
            place = (reading.folder / AXES_FILE, f"{axis}/endstop_pull", own.endstop_pull)
            yield problem(*place, reason, Pull.UP.value)


def _axis_uses(reading: Reading) -> Iterator[PinUse]:
    levels = [one.value for one in Level]
    for axis, section in AXIS_SECTIONS.items():
        values = reading.sections[section]
        level = values.get("enable_active", Level.LOW.value)
        for name, pin in values.items():
            key = f"{axis}/{name}"
            given = (AXES_FILE, key) in reading.given
            # A default says nothing where a key is misspelt, and a controller has no pins.
            known = type(pin) is int and (given or section not in reading.unsure)
            if not name.endswith("_pin") or not known or values.get("controller"):
                continue
            text = f"{AXES_FILE} {key}" if given else f"{AXES_FILE} {key} (default)"
            if name != SHARED:
                yield PinUse(pin, AXES_FILE, key, pin, text)
            elif level in levels:
                yield PinUse(pin, AXES_FILE, key, pin, text, f"{name} {level}")


def _spi(reading: Reading, uses: List[PinUse]) -> Iterator[Problem]:
    """Add the lines of the height sensor to the uses, or find that there are none."""
    sensor, file = reading.record("height_sensor"), reading.folder / HEIGHT_FILE
    if "height_sensor" in reading.unsure:
        return
    bus, device = sensor.spi_bus, sensor.spi_device
    if bus not in SPI_BUSES:
        reason = "the header of a Raspberry Pi 4 has no such bus"
        yield problem(file, "spi_bus", bus, reason, ", ".join(map(str, SPI_BUSES)))
        return
    last = len(SPI_BUSES[bus][1]) - 1
    if device > last:
        reason = f"SPI bus {bus} has no such chip select"
        yield problem(file, "spi_device", device, reason, f"0 - {last}")
        return
    for name, pin in spi_pins(bus, device).items():
        key, value = ("spi_device", device) if name.startswith("CE") else ("spi_bus", bus)
        uses.append(PinUse(pin, HEIGHT_FILE, key, value, f"{HEIGHT_FILE} {key}: SPI{bus} {name}"))


def _shared(reading: Reading, uses: List[PinUse]) -> Iterator[Problem]:
    by_pin: Dict[int, List[PinUse]] = {}
    for use in uses:
        by_pin.setdefault(use.pin, []).append(use)
    allowed = (
        "a pin of its own for each; axes can share only enable_pin, with the same enable_active"
    )
    for pin, own in by_pin.items():
        last, sharing = own[-1], {one.shared for one in own}
        if pin in GPIO_OF_BOARD and len(own) > 1 and (len(sharing) > 1 or not last.shared):
            reason = (
                f"pin {pin} (GPIO{GPIO_OF_BOARD[pin]}) has {len(own)} purposes: "
                f"{', '.join(one.text for one in own)}; find out with a continuity meter where it "
                "leads, as docs/first_real_survey.md describes"
            )
            yield problem(reading.folder / last.file, last.key, last.value, reason, allowed)
