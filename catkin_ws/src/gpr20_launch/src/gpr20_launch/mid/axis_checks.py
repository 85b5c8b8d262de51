"""Whether travel, steps, speed and acceleration of each axis can be those of this robot."""

from __future__ import annotations

import math
from typing import Any, Iterator, Mapping, NamedTuple

from gpr20_launch.mid.problem import Problem, problem
from gpr20_launch.mid.robot_files import AXES_FILE, Reading
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import LINEAR, ROTARY, AxisParameters

# In mm, deg and seconds. Steps of a belt or a screw with microsteps, and of a motor with or without
# a gear; beyond these speeds nothing of this size stays on its rails, or no stepper motor follows.
STEPS = {LINEAR: (0.0005, 1.0), ROTARY: (0.001, 15.0)}
FASTEST_PER_S = {LINEAR: 500.0, ROTARY: 1080.0}
# An axis without room for a row of traces is in metres, no positioner of this kind is longer.
SHORTEST_MM, LONGEST_MM = 20.0, 3000.0
# The cables of the antennas allow a quarter turn each way.
FARTHEST_TURN_DEG = 100.0
# A switch that is broken is pushed that far beyond; coordinates begin that far from the endstop.
LONGEST_MARGIN, LONGEST_BACKOFF = 50.0, 20.0
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
_STEP = "; measure the step, as docs/calibrate.md describes"
MEASURE = {"min_coord": _TRAVEL, "max_coord": _TRAVEL, "step_size": _STEP}
UNITS = {"cm": 10.0, "inches": 25.4, "radians": math.degrees(1.0)}


class Rule(NamedTuple):
    """One relation: whether it is broken, the key that is named, its unit, why, what is allowed."""

    broken: bool
    key: str
    unit: str
    reason: str
    allowed: str


def check_axes(reading: Reading) -> Iterator[Problem]:
    """Find travels, steps, speeds and accelerations that cannot be, or hardly."""
    file = reading.folder / AXES_FILE
    for axis, own in reading.axes().items():
        kind = ROTARY if axis == AxisId.Z.value else LINEAR
        if own.type != kind:
            reason = "x and y move along a line in mm, z turns in degrees"
            yield problem(file, f"{axis}/type", own.type, reason, kind)
            continue
        wrong = [one for one in _impossible(own) if one.broken]
        # What is doubtful may follow from what is wrong.
        broken = wrong or [one for one in _doubtful(own, reading.built[axis]) if one.broken]
        for one in broken:
            value = f"{getattr(own, one.key):g} {one.unit}"
            reason = one.reason + MEASURE.get(one.key, "")
            yield problem(file, f"{axis}/{one.key}", value, reason, one.allowed, not wrong)


def _impossible(own: AxisParameters) -> Iterator[Rule]:
    unit, (least, most) = own.unit, STEPS[own.type]
    farthest, travel = FARTHEST_TURN_DEG, own.max_coord - own.min_coord
    for key in ("min_coord", "max_coord"):
        far = own.type == ROTARY and abs(getattr(own, key)) > farthest
        reason = "the antennas would wind up their cables"
        yield Rule(far, key, unit, reason, f"{-farthest:g} - {farthest:g} deg")
    yield Rule(
        own.type == LINEAR and not SHORTEST_MM <= travel <= LONGEST_MM,
        *("max_coord" if abs(own.max_coord) >= abs(own.min_coord) else "min_coord", unit),
        f"a travel of {travel:g} {unit} cannot be",
        f"a travel of {SHORTEST_MM:g} to {LONGEST_MM:g} {unit}",
    )
    yield Rule(
        *(not least <= own.step_size <= most, "step_size", unit),
        "no motor of this robot has such steps",
        f"{least:g} - {most:g} {unit}",
    )
    for key, most, reason in (
        ("homing_margin", LONGEST_MARGIN, "an endstop that is broken would be passed by that much"),
        ("homing_backoff", LONGEST_BACKOFF, "coordinates would begin that much farther away"),
    ):
        yield Rule(getattr(own, key) > most, key, unit, reason, f"0 - {most:g} {unit}")
    speed, fastest = 0.5 * own.step_size / own.min_step, FASTEST_PER_S[own.type]
    yield Rule(
        *(speed > fastest, "min_step", "s"),
        f"with step_size {own.step_size:g} the axis would move at {speed:.0f} {unit}/s",
        f">= {0.5 * own.step_size / fastest:.3g} s",
    )
    homing_s = 2.0 * own.max_step * own.travel_steps
    yield Rule(
        *(homing_s > LONGEST_HOMING_S and travel <= LONGEST_MM, "step_size", unit),
        f"its homing could take {homing_s / 3600.0:.1f} hours with max_step {own.max_step:g}; if "
        "the steps are larger than that, each move is too long by as much",
        f"<= {LONGEST_HOMING_S / 3600.0:g} h",
    )


def _doubtful(own: AxisParameters, built: Mapping[str, Any]) -> Iterator[Rule]:
    unit, step = own.unit, built["step_size"]
    yield Rule(
        *(not 1.0 / STEP_OF_BUILT < own.step_size / step < STEP_OF_BUILT, "step_size", unit),
        f"the robot was built with {step:g} {unit}; each move is wrong by as much as the step",
        f"{step / STEP_OF_BUILT:g} - {step * STEP_OF_BUILT:g} {unit}",
    )
    yield from _travel(own, built) if own.type == LINEAR else _turn(own)
    # The largest change of speed is between the last two steps of the ramp.
    slower = min(own.max_step, own.min_step + own.delta_step)
    change = own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
    yield Rule(
        *(change > FASTEST_CHANGE_PER_S2, "delta_step", "s"),
        f"with min_step {own.min_step:g} it would accelerate by {change:.0f} {unit}/s2",
        f"<= {FASTEST_CHANGE_PER_S2:.0f} {unit}/s2",
    )
    ramp_s = own.max_step - own.min_step
    yield Rule(
        *(0.0 < ramp_s < own.delta_step, "delta_step", "s"),
        f"from max_step {own.max_step:g} to min_step {own.min_step:g} there would be no ramp",
        f"<= {ramp_s:.3g} s",
    )
    start_hz = 0.5 / own.max_step
    yield Rule(
        *(start_hz > FASTEST_START_HZ, "max_step", "s"),
        f"the motor would start with {start_hz:.0f} steps per second",
        f">= {0.5 / FASTEST_START_HZ:g} s",
    )
    latest_s = LATEST_PULSE * own.min_step
    yield Rule(
        *(own.late_limit_s > latest_s, "late_limit_s", "s"),
        f"with min_step {own.min_step:g} the pulse after a late one could be lost",
        f"<= {latest_s:g} s",
    )


def _travel(own: AxisParameters, built: Mapping[str, Any]) -> Iterator[Rule]:
    low, high, unit = built["min_coord"], built["max_coord"], own.unit
    travel, allowed = own.max_coord - own.min_coord, f"{low:g} - {high:g} {unit}"
    short = travel < SHORTEST_OF_BUILT * (high - low)
    reason = "that of the robot's description (URDF) is much longer"
    yield Rule(short, "max_coord", unit, reason + _unit_hint(travel, high - low), allowed)
    reason = "the robot's description (URDF) ends before"
    for end in ("min_coord", "max_coord"):
        outside = not low - 1e-3 <= getattr(own, end) <= high + 1e-3
        yield Rule(outside, end, unit, reason, allowed)


def _turn(own: AxisParameters) -> Iterator[Rule]:
    # A survey with both polarizations turns the antennas to 0 and 90 degrees.
    reason = "surveys turn the antennas to 0 and 90 degrees" + _unit_hint(own.max_coord, 90.0)
    yield Rule(own.min_coord > 0.0, "min_coord", "deg", reason, "<= 0 deg")
    yield Rule(own.max_coord < 90.0, "max_coord", "deg", reason, ">= 90 deg")
    reached = own.coordinate_of(own.distance_steps(90.0))
    inexact = abs(reached - 90.0) > LARGEST_TURN_ERROR_DEG
    reason = f"for 90 deg the antennas would turn to {reached:g}"
    yield Rule(inexact, "step_size", "deg", reason, "90 deg / n")


def _unit_hint(value: float, usual: float) -> str:
    near = [unit for unit, factor in UNITS.items() if 0.9 < value * factor / usual < 1.1]
    return f"; it seems to be in {near[0]}" if near else ""
