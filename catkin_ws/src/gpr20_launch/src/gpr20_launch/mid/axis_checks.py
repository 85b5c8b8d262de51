"""Whether travel, speed and acceleration of each axis can be those of this robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Tuple, Union

from gpr20_common.message import Message
from gpr20_launch.mid.hints import with_hint
from gpr20_launch.mid.problem import Problem, problem
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import LINEAR, ROTARY, AxisParameters


@dataclass(frozen=True)
class Limits:
    """What every axis of a kind keeps to; lengths in its unit.

    Attributes:
        type: LIN or ROT.
        unit: mm or deg.
        step: Finest and coarsest step. With finer ones every move would be too long.
        fastest: Beyond it nothing of this size stays on its rails, or no stepper motor follows.
    """

    type: str
    unit: str
    step: Tuple[float, float]
    fastest: float


# Steps of a belt or a screw with microsteps, and of a motor with or without a gear.
MOVING = Limits(LINEAR, "mm", (0.0005, 1.0), 500.0)
TURNING = Limits(ROTARY, "deg", (0.001, 15.0), 1080.0)
# An axis without room for a row of traces is in metres, no positioner of this kind is longer.
SHORTEST_MM, LONGEST_MM = 20.0, 3000.0
# The cables of the antennas allow a quarter turn each way.
FARTHEST_TURN_DEG = 100.0
# A switch that is broken is pushed that far beyond.
LONGEST_MARGIN = 50.0
# Coordinates begin that far from the endstop, so the axis ends that much farther, too.
LONGEST_BACKOFF = 20.0
FASTEST_START_HZ = 1000.0
FASTEST_CHANGE_PER_S2 = 2.0e4
# Longer than anybody waits for the homing of an axis.
LONGEST_HOMING_S = 3600.0
# Of the shortest pause: with more a motor may lose steps.
LATEST_PULSE = 0.8
# The antennas turn to these rotations in a survey with both polarizations.
ROTATIONS_DEG = (0.0, 90.0)
LARGEST_TURN_ERROR_DEG = 0.25
SHORTEST_OF_BUILT = 0.5
# In mm and degrees.
_TRAVEL = Message("measure how far the axis can move")
_STEP = Message("measure the step, as docs/calibrate.md describes")
MEASURE = {"min_coord": _TRAVEL, "max_coord": _TRAVEL, "step_size": _STEP}
UNITS = {"cm": 10.0, "inches": 25.4, "radians": math.degrees(1.0)}


def impossible_values(file: Path, axis: str, values: Mapping[str, Any]) -> Iterator[Problem]:
    """Find what cannot be, before the values are compared; unknown ones are left out."""
    limits = TURNING if axis == AxisId.Z.value else MOVING
    unit = limits.unit
    kind = values.get("type")
    if kind in (MOVING.type, TURNING.type) and kind != limits.type:
        reason = Message("x and y move along a line in mm, z turns in degrees")
        yield problem(file, f"{axis}/type", kind, reason, limits.type)
    low, high = (_number(values.get(key)) for key in ("min_coord", "max_coord"))
    # Where the ends are exchanged, the comparison says so.
    if limits is MOVING and high > low and not SHORTEST_MM <= high - low <= LONGEST_MM:
        key, end = ("max_coord", high) if abs(high) >= abs(low) else ("min_coord", low)
        reason = Message("a travel of {travel:g} {unit} cannot be", travel=high - low, unit=unit)
        ends = {"least": SHORTEST_MM, "most": LONGEST_MM, "unit": unit}
        allowed = Message("a travel of {least:g} to {most:g} {unit}", **ends)
        yield _problem(file, axis, key, f"{end:g} {unit}", reason, allowed)
    step = Message("no motor of this robot has such steps")
    broken = Message("an endstop that is broken would be passed by that much")
    farther = Message("every coordinate would lie that much farther from the endstop")
    cables = Message("the antennas would wind up their cables")
    turn = (-FARTHEST_TURN_DEG, FARTHEST_TURN_DEG, cables)
    turns = [("min_coord", *turn), ("max_coord", *turn)]
    for key, lower, upper, reason in (
        *(turns if limits is TURNING else ()),
        ("step_size", *limits.step, step),
        ("homing_margin", 0.0, LONGEST_MARGIN, broken),
        ("homing_backoff", 0.0, LONGEST_BACKOFF, farther),
    ):
        value = _number(values.get(key))
        if value < lower or value > upper:
            shown, bounds = f"{value:g} {unit}", f"{lower:g} - {upper:g} {unit}"
            yield _problem(file, axis, key, shown, reason, bounds)


def _problem(
    file: Path,
    axis: str,
    key: str,
    shown: str,
    reason: Message,
    allowed: Union[Message, str],
    doubtful: bool = False,
) -> Problem:
    reason = with_hint(reason, MEASURE.get(key))
    return problem(file, f"{axis}/{key}", shown, reason, allowed, doubtful)


def _number(value: Any) -> float:
    """Return a number; NaN, which compares as false, for anything else."""
    return float(value) if type(value) in (int, float) and abs(value) < 1e300 else math.nan


def check_axes(
    file: Path, axes: Mapping[str, AxisParameters], built: Mapping[str, Mapping[str, Any]]
) -> Iterator[Problem]:
    """Find travels, speeds and accelerations that cannot be, or hardly; `built` is as the URDF."""
    for axis, own in axes.items():
        check = _AxisCheck(file, axis, own)
        if axis == AxisId.Z.value:
            yield from check.turn()
        else:
            yield from check.travel(built[axis]["min_coord"], built[axis]["max_coord"])
        yield from check.motion()


@dataclass(frozen=True)
class _AxisCheck:
    """Compares the values of one axis."""

    file: Path
    axis: str
    own: AxisParameters

    def _problem(
        self, key: str, unit: str, reason: Message, allowed: str, doubt: bool = True
    ) -> Problem:
        shown = f"{getattr(self.own, key):g} {unit}"
        return _problem(self.file, self.axis, key, shown, reason, allowed, doubt)

    def turn(self) -> Iterator[Problem]:
        own, quarter = self.own, ROTATIONS_DEG[1]
        if not all(own.min_coord <= one <= own.max_coord for one in ROTATIONS_DEG):
            reason = Message("surveys turn the antennas to 0 and 90 degrees")
            reason = with_hint(reason, _unit_hint(own.max_coord, quarter))
            key, allowed = ("min_coord", "<= 0") if own.min_coord > 0 else ("max_coord", ">= 90")
            yield self._problem(key, "deg", reason, f"{allowed} deg")
        reached = own.coordinate_of(own.distance_steps(quarter))
        if abs(reached - quarter) > LARGEST_TURN_ERROR_DEG:
            reason = Message("for 90 deg the antennas would turn to {reached:g}", reached=reached)
            yield self._problem("step_size", "deg", reason, "90 deg / n")

    def travel(self, low: float, high: float) -> Iterator[Problem]:
        own, margin = self.own, 1.0e-6 * (high - low)
        allowed, travel = f"{low:g} - {high:g} mm", own.max_coord - own.min_coord
        if travel < SHORTEST_OF_BUILT * (high - low):
            reason = Message("that of the robot's description (URDF) is much longer")
            reason = with_hint(reason, _unit_hint(travel, high - low))
            yield self._problem("max_coord", "mm", reason, allowed)
        for end in ("min_coord", "max_coord"):
            if not low - margin <= getattr(own, end) <= high + margin:
                reason = Message("the robot's description (URDF) ends before")
                yield self._problem(end, "mm", reason, allowed)

    def motion(self) -> Iterator[Problem]:
        own, unit = self.own, self.own.unit
        fastest = (MOVING if own.type == MOVING.type else TURNING).fastest
        speed = 0.5 * own.step_size / own.min_step
        # The largest change is between the last two steps of the ramp.
        slower = min(own.max_step, own.min_step + own.delta_step)
        change = own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
        if speed > fastest:
            reason = Message("the axis would move at {speed:.0f} {unit}/s", speed=speed, unit=unit)
            allowed = f">= {0.5 * own.step_size / fastest:.3g} s"
            yield self._problem("min_step", "s", reason, allowed, doubt=False)
        elif change > FASTEST_CHANGE_PER_S2:
            reason = Message("it would accelerate by {rate:.0f} {unit}/s2", rate=change, unit=unit)
            allowed = f"<= {FASTEST_CHANGE_PER_S2:.0f} {unit}/s2"
            yield self._problem("delta_step", "s", reason, allowed)
        start_hz = 0.5 / own.max_step
        if start_hz > FASTEST_START_HZ:
            reason = Message(
                "the motor would start with {rate:.0f} steps per second", rate=start_hz
            )
            allowed = f">= {0.5 / FASTEST_START_HZ:g} s"
            yield self._problem("max_step", "s", reason, allowed)
        homing_s = 2.0 * own.max_step * own.travel_steps
        if homing_s > LONGEST_HOMING_S:
            reason = Message(
                "its homing could take {hours:.1f} hours; if the steps are larger than that, each "
                "move is too long by as much",
                hours=homing_s / 3600.0,
            )
            allowed = f"<= {LONGEST_HOMING_S / 3600.0:g} h"
            yield self._problem("step_size", unit, reason, allowed, doubt=False)
        if own.late_limit_s > LATEST_PULSE * own.min_step:
            reason = Message("after a late pulse the next one could follow at once, and be lost")
            allowed = f"<= {LATEST_PULSE * own.min_step:g} s"
            yield self._problem("late_limit_s", "s", reason, allowed)


def _unit_hint(value: float, usual: float) -> Optional[Message]:
    for unit, factor in UNITS.items():
        if 0.9 < value * factor / usual < 1.1:
            return Message("it seems to be in {unit}", unit=unit)
    return None
