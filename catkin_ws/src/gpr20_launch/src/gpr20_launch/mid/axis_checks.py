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
from gpr20_launch.mid.problem import Problem, problem
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters, AxisType

# No positioner of this kind is longer; an axis without room for a row of traces is in metres.
LONGEST_MM, SHORTEST_MM = 3000.0, 20.0
LARGEST_TURN_DEG = 360.0
# The cables of the antennas allow a quarter turn each way.
FARTHEST_TURN_DEG = 100.0
# Steps of a belt or a screw, and of a motor without a gear.
COARSEST_STEP_MM, COARSEST_STEP_DEG = 1.0, 15.0
# Of a motor with microsteps on a fine screw; with finer ones every move would be too long.
FINEST_STEP_MM, FINEST_STEP_DEG = 0.0005, 0.001
# A switch that is broken is pushed that far beyond.
LONGEST_MARGIN = 50.0
# Beyond them nothing of this size stays on its rails, or no stepper motor follows.
FASTEST_MM_S, FASTEST_DEG_S = 500.0, 1080.0
FASTEST_START_HZ = 1000.0
FASTEST_CHANGE_PER_S2 = 2.0e4
# Longer than anybody waits for the homing of an axis.
LONGEST_HOMING_S = 3600.0
# The antennas turn to these rotations in a survey with both polarizations.
ROTATIONS_DEG = (0.0, 90.0)
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
        values: All its values, whatever they are.
    """
    rotary = axis == AxisId.Z.value
    unit = "deg" if rotary else "mm"
    wanted = (AxisType.ROTARY if rotary else AxisType.LINEAR).value
    kinds = [one.value for one in AxisType]
    if values["type"] in kinds and values["type"] != wanted:
        reason = Message("x and y move along a line in mm, z turns in degrees")
        yield problem(faults.TRAVEL, file, f"{axis}/type", values["type"], reason, wanted)
    low, high, step = (_number(values[key]) for key in ("min_coord", "max_coord", "step_size"))
    least, most = (0.0, LARGEST_TURN_DEG) if rotary else (SHORTEST_MM, LONGEST_MM)
    # Where the ends are exchanged, the comparison says so.
    if high > low and not least <= high - low <= most:
        yield problem(
            faults.TRAVEL,
            file,
            f"{axis}/max_coord" if abs(high) >= abs(low) else f"{axis}/min_coord",
            f"{high if abs(high) >= abs(low) else low:g} {unit}",
            Message("a travel of {travel:g} {unit} cannot be", travel=high - low, unit=unit),
            Message("a travel of {least:g} to {most:g} {unit}", least=least, most=most, unit=unit),
        )
    if rotary:
        yield from _turns(file, axis, low, high)
    finest, coarsest = (
        (FINEST_STEP_DEG, COARSEST_STEP_DEG) if rotary else (FINEST_STEP_MM, COARSEST_STEP_MM)
    )
    if 0.0 < step < finest or step > coarsest:
        reason = Message("no motor of this robot has such steps")
        allowed, shown = f"{finest:g} - {coarsest:g} {unit}", f"{step:g} {unit}"
        yield problem(faults.MOTION, file, f"{axis}/step_size", shown, reason, allowed)
    margin = _number(values.get("homing_margin"))
    if margin > LONGEST_MARGIN:
        reason = Message("an endstop that is broken would be passed by that much")
        allowed, shown = f"<= {LONGEST_MARGIN:g} {unit}", f"{margin:g} {unit}"
        yield problem(faults.MOTION, file, f"{axis}/homing_margin", shown, reason, allowed)


def _turns(file: Path, axis: str, low: float, high: float) -> Iterator[Problem]:
    for key, end in (("min_coord", low), ("max_coord", high)):
        if FARTHEST_TURN_DEG < abs(end) <= LARGEST_TURN_DEG:
            reason = Message("the antennas would wind up their cables")
            allowed = f"-{FARTHEST_TURN_DEG:g} - {FARTHEST_TURN_DEG:g} deg"
            yield problem(faults.TRAVEL, file, f"{axis}/{key}", f"{end:g} deg", reason, allowed)


def _number(value: Any) -> float:
    """Return a number; NaN, which compares as false, for anything else."""
    return float(value) if type(value) in (int, float) and abs(value) < 1e300 else math.nan


def check_axes(
    file: Path, axes: Mapping[str, AxisParameters], frame: Optional[Frame]
) -> Iterator[Problem]:
    """Find travels, speeds and accelerations that cannot be, or hardly."""
    for axis, parameters in axes.items():
        if frame is not None:
            yield from _check_travel(file, axis, parameters, frame)
        if axis == AxisId.Z.value and not all(
            parameters.min_coord <= one <= parameters.max_coord for one in ROTATIONS_DEG
        ):
            reason = Message("surveys turn the antennas to 0 and 90 degrees")
            yield _doubtful(
                file, faults.TRAVEL, f"{axis}/max_coord", parameters.max_coord, reason, ">= 90"
            )
        yield from _check_motion(file, axis, parameters)


def _doubtful(
    file: Path, fault: Fault, key: str, value: object, reason: Message, allowed: str
) -> Problem:
    return problem(fault, file, key, value, reason, allowed, doubtful=True)


def _check_travel(file: Path, axis: str, own: AxisParameters, frame: Frame) -> Iterator[Problem]:
    low, high = frame.travel[axis]
    allowed = f"{low:g} - {high:g} {own.unit}"
    travel = own.max_coord - own.min_coord
    if travel > frame.outer_mm.get(axis, math.inf):
        reason = Message(
            "the travel of {travel:g} mm is longer than the frame of the robot's description, "
            "{outer:.0f} mm",
            travel=travel,
            outer=frame.outer_mm[axis],
        )
        shown = f"{own.max_coord:g} {own.unit}"
        yield _doubtful(file, faults.TRAVEL, f"{axis}/max_coord", shown, reason, allowed)
        return
    margin = 1.0e-6 * (high - low)
    for end in ("min_coord", "max_coord"):
        coordinate = getattr(own, end)
        if not low - margin <= coordinate <= high + margin:
            reason = Message("the robot's description (URDF) ends before")
            shown = f"{coordinate:g} {own.unit}"
            yield _doubtful(file, faults.TRAVEL, f"{axis}/{end}", shown, reason, allowed)


def _check_motion(file: Path, axis: str, own: AxisParameters) -> Iterator[Problem]:
    fastest = FASTEST_MM_S if own.type == AxisType.LINEAR.value else FASTEST_DEG_S
    speed = 0.5 * own.step_size / own.min_step
    if speed > fastest:
        reason = Message("the axis would move at {speed:.0f} {unit}/s", speed=speed, unit=own.unit)
        allowed, shown = f">= {0.5 * own.step_size / fastest:.3g} s", f"{own.min_step:g} s"
        yield problem(faults.MOTION, file, f"{axis}/min_step", shown, reason, allowed)
    start_hz = 0.5 / own.max_step
    if start_hz > FASTEST_START_HZ:
        reason = Message("the motor would start with {rate:.0f} steps per second", rate=start_hz)
        allowed, shown = f">= {0.5 / FASTEST_START_HZ:g} s", f"{own.max_step:g} s"
        yield _doubtful(file, faults.MOTION, f"{axis}/max_step", shown, reason, allowed)
    change = _largest_change(own)
    if change > FASTEST_CHANGE_PER_S2:
        reason = Message(
            "the axis would speed up by {change:.0f} {unit}/s in one second",
            change=change,
            unit=own.unit,
        )
        allowed, shown = f"<= {FASTEST_CHANGE_PER_S2:.0f} {own.unit}/s2", f"{own.delta_step:g} s"
        yield _doubtful(file, faults.MOTION, f"{axis}/delta_step", shown, reason, allowed)
    homing_s = 2.0 * own.max_step * own.travel_steps
    if homing_s > LONGEST_HOMING_S:
        reason = Message(
            "its homing could take {hours:.1f} hours, and if the steps are larger than that, each "
            "move is too long by as much",
            hours=homing_s / 3600.0,
        )
        allowed, shown = f"<= {LONGEST_HOMING_S / 3600.0:g} h", f"{own.step_size:g} {own.unit}"
        yield problem(faults.MOTION, file, f"{axis}/step_size", shown, reason, allowed)


def _largest_change(own: AxisParameters) -> float:
    """Return the largest acceleration on the ramp, between its last two steps."""
    slower = min(own.max_step, own.min_step + own.delta_step)
    return own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
