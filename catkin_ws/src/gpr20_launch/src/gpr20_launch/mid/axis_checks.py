"""Whether travel, speed and acceleration of each axis can be those of this robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Tuple
from xml.etree import ElementTree

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Fault, Message
from gpr20_launch import faults
from gpr20_launch.mid.hints import with_hint
from gpr20_launch.mid.problem import Problem, problem
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters, AxisType


@dataclass(frozen=True)
class Limits:
    """What every axis of a kind keeps to; lengths in its unit.

    Attributes:
        type: LIN or ROT.
        unit: mm or deg.
        travel: Shortest and longest travel.
        step: Finest and coarsest step. With finer ones every move would be too long.
        fastest: Beyond it nothing of this size stays on its rails, or no stepper motor follows.
    """

    type: str
    unit: str
    travel: Tuple[float, float]
    step: Tuple[float, float]
    fastest: float


# An axis without room for a row of traces is in metres, no positioner of this kind is longer. Steps
# of a belt or a screw with microsteps, and of a motor with or without a gear.
MOVING = Limits(AxisType.LINEAR.value, "mm", (20.0, 3000.0), (0.0005, 1.0), 500.0)
TURNING = Limits(AxisType.ROTARY.value, "deg", (0.0, 360.0), (0.001, 15.0), 1080.0)
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
SHORTEST_OF_DESCRIBED = 0.5
# In mm and degrees.
UNITS = {"cm": 10.0, "inches": 25.4, "radians": math.degrees(1.0)}
MM_PER_M = 1000.0
AXES = "xyz"


class DescriptionError(Gpr20Error, ValueError):
    """The description of the robot (URDF) cannot be used."""

    fault = faults.UNREADABLE


@dataclass(frozen=True)
class Frame:
    """Sizes of the robot in its description (URDF).

    Attributes:
        travel: Lower and upper end of each axis, by its name [mm, deg].
        outer_mm: Outer size of the frame along x and y, by its name [mm].
    """

    travel: Mapping[str, Tuple[float, float]]
    outer_mm: Mapping[str, float]


def read_frame(urdf: Path) -> Frame:
    """Return the sizes of the robot.

    Raises:
        DescriptionError: The file cannot be read, or lacks them.
    """
    try:
        root = ElementTree.parse(str(urdf)).getroot()
        return Frame({axis: _travel(root, axis) for axis in AXES}, dict(_outer_mm(root)))
    except (OSError, ElementTree.ParseError, AttributeError, ValueError, TypeError) as error:
        raise DescriptionError(
            Message("{file} does not describe the robot", file=urdf, details=error)
        ) from error


def _travel(root: ElementTree.Element, axis: str) -> Tuple[float, float]:
    limit = root.find(f"joint[@name='{axis}_axis_joint']/limit")
    scale = math.degrees(1.0) if axis == AxisId.Z.value else MM_PER_M
    if limit is None:
        raise ValueError(f"{axis}_axis_joint has no limit")
    return float(limit.attrib["lower"]) * scale, float(limit.attrib["upper"]) * scale


def _outer_mm(root: ElementTree.Element) -> Iterator[Tuple[str, float]]:
    parts = root.findall("link[@name='base_link']/visual")
    for index, axis in enumerate(AXES[:2]):
        ends = []
        for part in parts:
            middle = float(part.find("origin").attrib["xyz"].split()[index])  # type: ignore[union-attr]
            size = float(part.find("geometry/box").attrib["size"].split()[index])  # type: ignore[union-attr]
            ends += [middle - size / 2, middle + size / 2]
        yield axis, MM_PER_M * (max(ends) - min(ends))


def impossible_values(file: Path, axis: str, values: Mapping[str, Any]) -> Iterator[Problem]:
    """Find what cannot be, before the values are compared with each other.

    Args:
        file: Where the values are.
        axis: The axis.
        values: Its values, whatever they are; those that are not known are left out.
    """
    limits = TURNING if axis == AxisId.Z.value else MOVING
    unit = limits.unit
    kind = values.get("type")
    if kind in (MOVING.type, TURNING.type) and kind != limits.type:
        reason = Message("x and y move along a line in mm, z turns in degrees")
        yield problem(faults.WRONG_VALUE, file, f"{axis}/type", kind, reason, limits.type)
    low, high = (_number(values.get(key)) for key in ("min_coord", "max_coord"))
    least, most = limits.travel
    # Where the ends are exchanged, the comparison says so.
    if limits is MOVING and high > low and not least <= high - low <= most:
        key, end = ("max_coord", high) if abs(high) >= abs(low) else ("min_coord", low)
        reason = Message("a travel of {travel:g} {unit} cannot be", travel=high - low, unit=unit)
        allowed = Message(
            "a travel of {least:g} to {most:g} {unit}", least=least, most=most, unit=unit
        )
        yield problem(faults.TRAVEL, file, f"{axis}/{key}", f"{end:g} {unit}", reason, allowed)
    cables = Message("the antennas would wind up their cables")
    turn = (-FARTHEST_TURN_DEG, FARTHEST_TURN_DEG)
    ends = [(key, *turn, faults.TRAVEL, cables) for key in ("min_coord", "max_coord")]
    for key, lower, upper, fault, reason in (
        *(ends if limits is TURNING else ()),
        (
            *("step_size", *limits.step, faults.MOTION),
            Message("no motor of this robot has such steps"),
        ),
        (
            *("homing_margin", 0.0, LONGEST_MARGIN, faults.WRONG_VALUE),
            Message("an endstop that is broken would be passed by that much"),
        ),
        (
            *("homing_backoff", 0.0, LONGEST_BACKOFF, faults.WRONG_VALUE),
            Message("every coordinate would lie that much farther from the endstop"),
        ),
    ):
        value = _number(values.get(key))
        if value < lower or value > upper:
            shown, allowed = f"{value:g} {unit}", f"{lower:g} - {upper:g} {unit}"
            yield problem(fault, file, f"{axis}/{key}", shown, reason, allowed)


def _number(value: Any) -> float:
    """Return a number; NaN, which compares as false, for anything else."""
    return float(value) if type(value) in (int, float) and abs(value) < 1e300 else math.nan


def check_axes(
    file: Path, axes: Mapping[str, AxisParameters], frame: Optional[Frame]
) -> Iterator[Problem]:
    """Find travels, speeds and accelerations that cannot be, or hardly."""
    for axis, own in axes.items():
        if axis == AxisId.Z.value:
            doubts = _turn_doubts(own)
        else:
            doubts = _travel_doubts(axis, own, frame) if frame is not None else iter(())
        for one in (*doubts, *_motion_doubts(own)):
            shown = f"{getattr(own, one.key):g} {one.unit}"
            yield problem(
                *(one.fault, file, f"{axis}/{one.key}", shown, one.reason, one.allowed),
                doubtful=one.doubtful,
            )


@dataclass(frozen=True)
class _Doubt:
    """Something that cannot be, or hardly."""

    fault: Fault
    key: str
    unit: str
    reason: Message
    allowed: str
    doubtful: bool = True


def _turn_doubts(own: AxisParameters) -> Iterator[_Doubt]:
    if not all(own.min_coord <= one <= own.max_coord for one in ROTATIONS_DEG):
        reason = Message("surveys turn the antennas to 0 and 90 degrees")
        hint = _unit_hint(own.max_coord, ROTATIONS_DEG[1])
        yield _Doubt(faults.TRAVEL, "max_coord", "deg", with_hint(reason, hint), ">= 90 deg")
    reached = own.coordinate_of(own.distance_steps(ROTATIONS_DEG[1]))
    if abs(reached - ROTATIONS_DEG[1]) > LARGEST_TURN_ERROR_DEG:
        reason = Message("the rotation of 90 deg would be one of {reached:g} deg", reached=reached)
        yield _Doubt(faults.MOTION, "step_size", "deg", reason, "90 deg / n")


def _unit_hint(value: float, usual: float) -> Optional[Message]:
    for unit, factor in UNITS.items():
        if 0.9 < value * factor / usual < 1.1:
            return Message("it seems to be in {unit}", unit=unit)
    return None


def _travel_doubts(axis: str, own: AxisParameters, frame: Frame) -> Iterator[_Doubt]:
    low, high = frame.travel[axis]
    allowed = f"{low:g} - {high:g} {own.unit}"
    travel = own.max_coord - own.min_coord
    if travel > frame.outer_mm[axis]:
        reason = Message(
            "the travel of {travel:g} mm is longer than the frame of the robot's description, "
            "{outer:.0f} mm",
            travel=travel,
            outer=frame.outer_mm[axis],
        )
        yield _Doubt(faults.TRAVEL, "max_coord", own.unit, reason, allowed)
        return
    if travel < SHORTEST_OF_DESCRIBED * (high - low):
        reason = Message(
            "the travel of {travel:g} mm is much shorter than in the robot's description (URDF)",
            travel=travel,
        )
        reason = with_hint(reason, _unit_hint(travel, high - low))
        yield _Doubt(faults.TRAVEL, "max_coord", own.unit, reason, allowed)
    margin = 1.0e-6 * (high - low)
    for end in ("min_coord", "max_coord"):
        if not low - margin <= getattr(own, end) <= high + margin:
            reason = Message("the robot's description (URDF) ends before")
            yield _Doubt(faults.TRAVEL, end, own.unit, reason, allowed)


def _motion_doubts(own: AxisParameters) -> Iterator[_Doubt]:
    unit = own.unit
    fastest = (MOVING if own.type == MOVING.type else TURNING).fastest
    # The largest one is between the last two steps of the ramp.
    slower = min(own.max_step, own.min_step + own.delta_step)
    change = own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
    speed = 0.5 * own.step_size / own.min_step
    if speed > fastest:
        reason = Message("the axis would move at {speed:.0f} {unit}/s", speed=speed, unit=unit)
        allowed = f">= {0.5 * own.step_size / fastest:.3g} s"
        yield _Doubt(faults.MOTION, "min_step", "s", reason, allowed, doubtful=False)
    elif change > FASTEST_CHANGE_PER_S2:
        reason = Message(
            "the axis would speed up by {change:.0f} {unit}/s in one second",
            change=change,
            unit=unit,
        )
        allowed = f"<= {FASTEST_CHANGE_PER_S2:.0f} {unit}/s2"
        yield _Doubt(faults.MOTION, "delta_step", "s", reason, allowed)
    start_hz = 0.5 / own.max_step
    if start_hz > FASTEST_START_HZ:
        reason = Message("the motor would start with {rate:.0f} steps per second", rate=start_hz)
        yield _Doubt(faults.MOTION, "max_step", "s", reason, f">= {0.5 / FASTEST_START_HZ:g} s")
    homing_s = 2.0 * own.max_step * own.travel_steps
    if homing_s > LONGEST_HOMING_S:
        reason = Message(
            "its homing could take {hours:.1f} hours, and if the steps are larger than that, each "
            "move is too long by as much",
            hours=homing_s / 3600.0,
        )
        allowed = f"<= {LONGEST_HOMING_S / 3600.0:g} h"
        yield _Doubt(faults.MOTION, "step_size", unit, reason, allowed, doubtful=False)
    if own.late_limit_s > LATEST_PULSE * own.min_step:
        reason = Message("after a late pulse the next one could follow at once, and be lost")
        allowed = f"<= {LATEST_PULSE * own.min_step:g} s"
        yield _Doubt(faults.WRONG_VALUE, "late_limit_s", "s", reason, allowed)
