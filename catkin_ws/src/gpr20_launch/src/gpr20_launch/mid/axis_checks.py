"""Whether travel, steps, speed and acceleration of each axis can be those of this robot."""

from __future__ import annotations

from typing import Any, Iterator, Mapping, Tuple

from gpr20_launch.mid.robot_files import AXES_FILE, Problem, Reading, problem
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
