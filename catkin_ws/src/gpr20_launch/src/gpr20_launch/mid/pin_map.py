"""What each pin of the header is used for, by the whole robot.

The table is that of the Raspberry Pi 4: "Raspberry Pi 4 Model B Datasheet" (header), "BCM2711 ARM
Peripherals", section 5.3 (functions of the GPIO lines), and the firmware's overlays/README (which
lines a SPI bus takes).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Tuple

from gpr20_axis_driver.low.pigpio_waves import GPIO_OF_BOARD
from gpr20_common.message import Fault, Message
from gpr20_launch import faults
from gpr20_launch.problem import Problem, problem
from gpr20_survey.axes.axis_parameters import AxisParameters, Pull

PINS = ("dir_pin", "step_pin", "sensor_pin", "enable_pin")
ENABLE = "enable_pin"
BOARD_OF_GPIO = {gpio: pin for pin, gpio in GPIO_OF_BOARD.items()}
SUPPLY = {
    **dict.fromkeys((1, 17), "3.3 V"),
    **dict.fromkeys((2, 4), "5 V"),
    **dict.fromkeys((6, 9, 14, 20, 25, 30, 34, 39), "GND"),
}
I2C = {3: "I2C SDA", 5: "I2C SCL"}
UART = {8: "UART TXD", 10: "UART RXD"}
# The computer asks a board for its identification there whenever it starts.
IDENTIFICATION = {27: "ID_SD", 28: "ID_SC"}
# GPIO lines of a SPI bus: MISO, MOSI, SCLK, then its chip selects. Bus 2 is not on the header.
SPI: Mapping[int, Tuple[int, ...]] = {
    0: (9, 10, 11, 8, 7),
    1: (19, 20, 21, 18, 17, 16),
    3: (1, 2, 3, 0, 24),
    4: (5, 6, 7, 4, 25),
    5: (13, 14, 15, 12, 26),
    6: (19, 20, 21, 18, 27),
}
SPI_LINES = ("MISO", "MOSI", "SCLK")


@dataclass(frozen=True)
class PinUse:
    """One use of a pin by an axis.

    Attributes:
        axis: x, y or z.
        name: The parameter, such as dir_pin.
        pin: Its value, whatever number that is.
        shared: What must be equal where several axes share the pin; empty: it cannot be shared.
    """

    axis: str
    name: str
    pin: int
    shared: str = ""

    @property
    def key(self) -> str:
        """Name of the value in the file."""
        return f"{self.axis}/{self.name}"


def pin_uses(axes: Mapping[str, Mapping[str, Any]]) -> List[PinUse]:
    """Return each pin of each axis that is moved by pins; values that are no whole numbers apart.

    Args:
        axes: The values of each axis.
    """
    found = []
    for axis, values in axes.items():
        for name in PINS:
            pin = values.get(name)
            if values.get("controller") or isinstance(pin, bool) or not isinstance(pin, int):
                continue
            level = str(values.get("enable_active", AxisParameters.enable_active))
            found.append(PinUse(axis, name, pin, f"{name} {level}" if name == ENABLE else ""))
    return found


def pin_problems(
    axes_file: Path,
    axes: Mapping[str, Mapping[str, Any]],
    height_file: Path,
    height: Mapping[str, Any],
) -> List[Problem]:
    """Return what is wrong with the pins of the axes and of the height sensor's bus."""
    uses = pin_uses(axes)
    bus, found = _spi(height_file, height)
    for use in uses:
        found += _suitable(axes_file, use, axes[use.axis])
    found += _shared(axes_file, uses)
    for use in uses:
        if use.pin in bus:
            found.append(_on_bus(axes_file, height_file, use, bus[use.pin], height))
    return found


def _spi(file: Path, height: Mapping[str, Any]) -> Tuple[Dict[int, str], List[Problem]]:
    """Return the function of each pin of the bus that is used, by its BOARD number."""
    number, device = (height.get(name, 0) for name in ("spi_bus", "spi_device"))
    lines = SPI.get(number, ())
    selects = len(lines) - len(SPI_LINES)
    if not lines:
        allowed = ", ".join(map(str, SPI))
        reason = Message(
            "{place} is {value}; it must be one of {allowed}",
            place="spi_bus",
            value=number,
            allowed=allowed,
        )
        return {}, [problem(file, reason, "spi_bus", number)]
    names = [f"SPI{number} {name}" for name in SPI_LINES]
    names += [f"SPI{number} CE{one}" for one in range(selects)]
    found = {BOARD_OF_GPIO[gpio]: name for gpio, name in zip(lines, names)}
    if device in range(selects):
        return found, []
    reason = Message(
        "{name} is {value}; it must lie between {lower} and {upper}",
        name="spi_device",
        value=device,
        lower=0,
        upper=selects - 1,
    )
    return found, [problem(file, reason, "spi_device", device)]


def _suitable(file: Path, use: PinUse, axis: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield what the header has at a pin beside a free GPIO line."""
    pin, pulled_down = use.pin, axis.get("endstop_pull") == Pull.DOWN.value
    if pin not in GPIO_OF_BOARD:
        there = SUPPLY.get(pin, "-")
        reason = _no_gpio(use, there)
        yield _of_pin(problem(file, reason, use.key, pin, faults.PIN_CONFLICT), use, there)
    elif pin in IDENTIFICATION:
        reason = Message(
            "{key} is {pin}, where the header has {function}: the computer drives it whenever it "
            "starts; choose another pin",
            key=use.key,
            pin=pin,
            function=IDENTIFICATION[pin],
        )
        made = problem(file, reason, use.key, pin, faults.PIN_CONFLICT)
        yield _of_pin(made, use, IDENTIFICATION[pin])
    elif pin in I2C and use.name == "sensor_pin" and pulled_down:
        reason = Message(
            "{key} is {pin}, which a resistor of 1.8 kOhm on the computer pulls up, and "
            "{pull} is {down}: the endstop reads the same all the time; choose another pin",
            key=use.key,
            pin=pin,
            pull="endstop_pull",
            down=Pull.DOWN.value,
        )
        yield _of_pin(problem(file, reason, use.key, pin, faults.PIN_CONFLICT), use, I2C[pin])
    elif pin in {**I2C, **UART}:
        function = {**I2C, **UART}[pin]
        reason = Message(
            "{key} is {pin}, which is also {function}: the pin may change while the computer "
            "starts; switch that off, or choose another pin",
            key=use.key,
            pin=pin,
            function=function,
        )
        yield _of_pin(problem(file, reason, use.key, pin, faults.DOUBTFUL_VALUE), use, function)


def _no_gpio(use: PinUse, there: str) -> Message:
    pins = ", ".join(map(str, sorted(GPIO_OF_BOARD)))
    if use.pin in BOARD_OF_GPIO:
        return Message(
            "{key} is {pin}, where the header has {function}; it must be the BOARD number of a "
            "GPIO pin: {pins}. If GPIO {pin} is meant, write {board}",
            key=use.key,
            pin=use.pin,
            function=there,
            pins=pins,
            board=BOARD_OF_GPIO[use.pin],
        )
    return Message(
        "{key} is {pin}, where the header has {function}; it must be the BOARD number of a GPIO "
        "pin: {pins}",
        key=use.key,
        pin=use.pin,
        function=there,
        pins=pins,
    )


def _shared(file: Path, uses: List[PinUse]) -> Iterator[Problem]:
    """Yield each pin with two uses, unless it enables the motor drivers of several axes."""
    first: Dict[int, PinUse] = {}
    for use in uses:
        other = first.setdefault(use.pin, use)
        if other is use or other.shared == use.shared != "":
            continue
        reason = Message(
            "{first} and {second} both use pin {pin}; give each a pin of its own: axes can share "
            "only {shared}, with the same {level}",
            first=other.key,
            second=use.key,
            pin=use.pin,
            shared=ENABLE,
            level="enable_active",
        )
        made = problem(file, reason, use.key, use.pin, faults.PIN_CONFLICT)
        yield _of_pin(made, use, other.key)


def _on_bus(
    file: Path, height_file: Path, use: PinUse, function: str, height: Mapping[str, Any]
) -> Problem:
    """Return the problem of a pin of the height sensor's bus; another chip select is doubtful."""
    chosen = f"CE{height.get('spi_device', 0)}"
    spare = "CE" in function and not function.endswith(chosen)
    fault: Fault = faults.DOUBTFUL_VALUE if spare else faults.PIN_CONFLICT
    reason = Message(
        "{key} is {pin}, which is also {function} of the height sensor's converter ({file}); give "
        "each a pin of its own",
        key=use.key,
        pin=use.pin,
        function=function,
        file=height_file.name,
    )
    return _of_pin(problem(file, reason, use.key, use.pin, fault), use, function)


def _of_pin(made: Problem, use: PinUse, other: str) -> Problem:
    return replace(made, pin=use.pin, uses=(other, use.key))
