"""The axes and the pins of the whole robot: whether they can be, and go together.

The pins are those of the header of a Raspberry Pi 4, from the pinout of its documentation
(raspberrypi.com, "GPIO and the 40-pin header"), the alternative functions in the data sheet
"BCM2711 ARM Peripherals", section 5.3, and the chip selects that the overlays spi0 to spi6 of the
Raspberry Pi's kernel use by default.
"""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Tuple

from gpr20_launch.mid.robot_files import AXES_FILE, AXIS_SECTIONS, Problem, Reading, problem
from gpr20_survey.axes import LINEAR, ROTARY, AxisId, AxisParameters, Level, Pull

# Pins of the header [BOARD] that carry no signal.
NOT_GPIO: Mapping[int, str] = {
    **dict.fromkeys((1, 17), "3.3 V"),
    **dict.fromkeys((2, 4), "5 V"),
    **dict.fromkeys((6, 9, 14, 20, 25, 30, 34, 39), "ground"),
}
GPIO_OF_BOARD: Mapping[int, int] = {
    **{3: 2, 5: 3, 7: 4, 8: 14, 10: 15, 11: 17, 12: 18, 13: 27, 15: 22, 16: 23, 18: 24, 19: 10},
    **{21: 9, 22: 25, 23: 11, 24: 8, 26: 7, 27: 0, 28: 1, 29: 5, 31: 6, 32: 12, 33: 13, 35: 19},
    **{36: 16, 37: 26, 38: 20, 40: 21},
}
BOARD_OF_GPIO: Mapping[int, int] = {gpio: board for board, gpio in GPIO_OF_BOARD.items()}

# At every start the firmware looks for an EEPROM here, with pulses of its own.
EEPROM = (27, 28)
I2C = (3, 5)
# GPIO numbers of MISO, MOSI and SCLK, and of the chip selects. Bus 2 is not on the header.
SPI_BUSES: Mapping[int, Tuple[Tuple[int, int, int], Tuple[int, ...]]] = {
    0: ((9, 10, 11), (8, 7)),
    1: ((19, 20, 21), (18, 17, 16)),
    3: ((1, 2, 3), (0, 24)),
    4: ((5, 6, 7), (4, 25)),
    5: ((13, 14, 15), (12, 26)),
    6: ((19, 20, 21), (18, 27)),
}
RESERVED: Mapping[int, str] = {
    **dict.fromkeys(
        EEPROM, "at every start the Raspberry Pi sends pulses to this pin, looking for an EEPROM"
    ),
    **dict.fromkeys(
        (8, 10), "this is the serial port, whose console Linux prints on unless it is off"
    ),
    **dict.fromkeys(I2C, "this is I2C, with a resistor of 1.8 kOhm to 3.3 V"),
    26: "this is CE1 of SPI0, which Linux drives unless only one chip select is set up",
}


def spi_pins(bus: int, device: int) -> Dict[str, int]:
    """Return name and pin [BOARD] of each line that a device of a bus uses."""
    lines, selects = SPI_BUSES[bus]
    named = {**dict(zip(("MISO", "MOSI", "SCLK"), lines)), f"CE{device}": selects[device]}
    return {name: BOARD_OF_GPIO[gpio] for name, gpio in named.items()}


# For anything: what neither the Raspberry Pi nor the usual converter uses.
FREE = sorted({*GPIO_OF_BOARD} - {*RESERVED} - {*spi_pins(0, 0).values()})
HEIGHT_FILE = "height.yaml"


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
            if name != "enable_pin":  # it may enable the drivers of several axes
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
                "leads, as docs/coming_from_the_original.md describes"
            )
            yield problem(reading.folder / last.file, last.key, last.value, reason, allowed)


# In mm, deg and seconds. Steps of a belt or a screw with microsteps, and of a motor with or without
# a gear; beyond these speeds nothing of this size stays on its rails, or no stepper motor follows.
STEPS = {LINEAR: (0.0005, 1.0), ROTARY: (0.001, 15.0)}
FASTEST_PER_S = {LINEAR: 500.0, ROTARY: 1080.0}
# An axis without room for a row of traces is in metres, no positioner of this kind is longer.
SHORTEST_MM, LONGEST_MM = 20.0, 3000.0
# The cables of the antennas allow a quarter turn each way.
FARTHEST_TURN_DEG = 100.0
FASTEST_START_HZ, FASTEST_CHANGE_PER_S2 = 1000.0, 2.0e4
# Longer than anybody waits for the homing of an axis.
LONGEST_HOMING_S = 3600.0
# Of the shortest pause: with more a motor may lose steps.
LATEST_PULSE = 0.8
LARGEST_TURN_ERROR_DEG = 0.25
SHORTEST_OF_BUILT = 0.5
# Of the step as built; another motor, belt or microstepping is within it.
STEP_OF_BUILT = 5.0
_TRAVEL = "; measure how far the axis can move"
_STEP = "; measure the step, as docs/first_real_survey.md describes"
MEASURE = {"min_coord": _TRAVEL, "max_coord": _TRAVEL, "step_size": _STEP}
PAUSES = ("min_step", "max_step", "delta_step", "late_limit_s")


# Key, why it is wrong or doubtful, and what is allowed.
Finding = Tuple[str, str, str]


def check_axes(reading: Reading) -> Iterator[Problem]:
    """Find travels, steps, speeds and accelerations that cannot be, or hardly."""
    file = reading.folder / AXES_FILE
    for axis, own in reading.axes().items():
        kind = ROTARY if axis == AxisId.Z.value else LINEAR
        if own.type != kind:
            reason = "x and y move along a line in mm, z turns in degrees"
            yield problem(file, f"{axis}/type", own.type, reason, kind)
            continue
        wrong = list(_impossible(own))
        # What is doubtful may follow from what is wrong.
        for key, reason, allowed in wrong or _doubtful(own, reading.built[axis]):
            unit = "s" if key in PAUSES else own.unit
            value = f"{getattr(own, key):g} {unit}"
            reason += MEASURE.get(key, "")
            yield problem(file, f"{axis}/{key}", value, reason, allowed, not wrong)


def _impossible(own: AxisParameters) -> Iterator[Finding]:
    unit, (least, most), fastest = own.unit, STEPS[own.type], FASTEST_PER_S[own.type]
    travel, farthest = own.max_coord - own.min_coord, FARTHEST_TURN_DEG
    for key in ("min_coord", "max_coord"):
        if own.type == ROTARY and abs(getattr(own, key)) > farthest:
            reason = "the antennas would wind up their cables"
            yield key, reason, f"{-farthest:g} - {farthest:g} deg"
    if own.type == LINEAR and not SHORTEST_MM <= travel <= LONGEST_MM:
        key = "max_coord" if abs(own.max_coord) >= abs(own.min_coord) else "min_coord"
        allowed = f"a travel of {SHORTEST_MM:g} to {LONGEST_MM:g} {unit}"
        yield key, f"a travel of {travel:g} {unit} cannot be", allowed
    if not least <= own.step_size <= most:
        yield "step_size", "no motor of this robot has such steps", f"{least:g} - {most:g} {unit}"
    speed, homing_s = 0.5 * own.step_size / own.min_step, 2.0 * own.max_step * own.travel_steps
    if speed > fastest:
        reason = f"with step_size {own.step_size:g} the axis would move at {speed:.0f} {unit}/s"
        yield "min_step", reason, f">= {0.5 * own.step_size / fastest:.3g} s"
    if homing_s > LONGEST_HOMING_S and travel <= LONGEST_MM:
        reason = f"its homing could take {homing_s / 3600.0:.1f} hours with max_step "
        reason += f"{own.max_step:g}; if the steps are larger, each move is too long by as much"
        yield "step_size", reason, f"<= {LONGEST_HOMING_S / 3600.0:g} h"


def _doubtful(own: AxisParameters, built: Mapping[str, Any]) -> Iterator[Finding]:
    unit, step, ramp_s = own.unit, built["step_size"], own.max_step - own.min_step
    if not 1.0 / STEP_OF_BUILT < own.step_size / step < STEP_OF_BUILT:
        reason = f"the robot was built with {step:g} {unit}; each move is wrong by as much"
        yield "step_size", reason, f"{step / STEP_OF_BUILT:g} - {step * STEP_OF_BUILT:g} {unit}"
    yield from _travel(own, built) if own.type == LINEAR else _turn(own)
    # The largest change of speed is between the last two steps of the ramp.
    slower = min(own.max_step, own.min_step + own.delta_step)
    change = own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
    if change > FASTEST_CHANGE_PER_S2:
        reason = f"with min_step {own.min_step:g} it would accelerate by {change:.0f} {unit}/s2"
        yield "delta_step", reason, f"<= {FASTEST_CHANGE_PER_S2:.0f} {unit}/s2"
    if 0.0 < ramp_s < own.delta_step:
        reason = f"from max_step {own.max_step:g} to min_step {own.min_step:g} is no ramp then"
        yield "delta_step", reason, f"<= {ramp_s:.3g} s"
    start_hz, latest_s = 0.5 / own.max_step, LATEST_PULSE * own.min_step
    if start_hz > FASTEST_START_HZ:
        reason = f"the motor would start with {start_hz:.0f} steps per second"
        yield "max_step", reason, f">= {0.5 / FASTEST_START_HZ:g} s"
    if own.late_limit_s > latest_s:
        reason = f"with min_step {own.min_step:g} the pulse after a late one could be lost"
        yield "late_limit_s", reason, f"<= {latest_s:g} s"


def _travel(own: AxisParameters, built: Mapping[str, Any]) -> Iterator[Finding]:
    low, high = built["min_coord"], built["max_coord"]
    travel, allowed = own.max_coord - own.min_coord, f"{low:g} - {high:g} {own.unit}"
    if travel < SHORTEST_OF_BUILT * (high - low):
        reason = "that of the robot's description (URDF) is much longer; is it in mm?"
        yield "max_coord", reason, allowed
    for end in ("min_coord", "max_coord"):
        if not low - 1e-3 <= getattr(own, end) <= high + 1e-3:
            yield end, "the robot's description (URDF) ends before", allowed


def _turn(own: AxisParameters) -> Iterator[Finding]:
    # A survey with both polarizations turns the antennas to 0 and 90 degrees.
    reason = "surveys turn the antennas to 0 and 90 degrees"
    if own.min_coord > 0.0:
        yield "min_coord", reason, "<= 0 deg"
    if own.max_coord < 90.0:
        yield "max_coord", reason, ">= 90 deg"
    reached = own.coordinate_of(own.distance_steps(90.0))
    if abs(reached - 90.0) > LARGEST_TURN_ERROR_DEG:
        yield "step_size", f"for 90 deg the antennas would turn to {reached:g}", "90 deg / n"
