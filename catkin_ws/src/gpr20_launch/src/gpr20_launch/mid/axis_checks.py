"""Whether travel, speed and acceleration of each axis can be those of this robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, Mapping, Optional, Tuple
from xml.etree import ElementTree

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_launch import faults
from gpr20_launch.mid.problem import Problem, problem
from gpr20_launch.mid.robot_files import AXES_FILE, Reading
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters, AxisType

# No positioner of this kind is longer; an axis without room for a row of traces is in metres.
LONGEST_MM, SHORTEST_MM = 3000.0, 20.0
LARGEST_TURN_DEG = 360.0
# Steps of a belt or a screw, and of a motor without a gear.
COARSEST_STEP_MM, COARSEST_STEP_DEG = 1.0, 15.0
# Beyond them nothing of this size stays on its rails, or no stepper motor follows.
FASTEST_MM_S, FASTEST_DEG_S = 500.0, 1080.0
FASTEST_START_HZ = 1000.0
FASTEST_CHANGE_PER_S2 = 1.0e5
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
    assert limit is not None, axis
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


def check_axes(reading: Reading, frame: Optional[Frame]) -> Iterator[Problem]:
    """Find travels, speeds and accelerations that cannot be, or hardly."""
    for axis, parameters in reading.axes().items():
        wanted = AxisType.ROTARY if axis == AxisId.Z.value else AxisType.LINEAR
        if parameters.type != wanted.value:
            yield problem(
                faults.TRAVEL,
                AXES_FILE,
                f"{axis}/type",
                parameters.type,
                Message("x and y move along a line in mm, z turns in degrees"),
                wanted.value,
            )
            continue
        yield from _check_travel(axis, parameters, frame)
        yield from _check_motion(axis, parameters)


def _check_travel(axis: str, own: AxisParameters, frame: Optional[Frame]) -> Iterator[Problem]:
    travel = own.max_coord - own.min_coord
    key, value = f"{axis}/max_coord", f"{own.max_coord:g} {own.unit}"
    linear = own.type == AxisType.LINEAR.value
    longest, shortest = (LONGEST_MM, SHORTEST_MM) if linear else (LARGEST_TURN_DEG, 0.0)
    described = None if frame is None else frame.travel[axis]
    low, high = described or (0.0, longest)
    allowed = f"{low:g} - {high:g} {own.unit}"
    if not shortest <= travel <= longest:
        reason = Message(
            "a travel of {travel:g} {unit} cannot be; the unit is {unit}",
            travel=travel,
            unit=own.unit,
        )
        yield problem(faults.TRAVEL, AXES_FILE, key, value, reason, allowed)
        return
    if frame is not None and linear and travel > frame.outer_mm[axis]:
        reason = Message(
            "the travel of {travel:g} mm is longer than the frame of the robot's description, "
            "{outer:.0f} mm",
            travel=travel,
            outer=frame.outer_mm[axis],
        )
        yield problem(faults.TRAVEL, AXES_FILE, key, value, reason, allowed, doubtful=True)
    elif described is not None:
        margin = 1.0e-6 * (high - low)
        for end, coordinate in (("min_coord", own.min_coord), ("max_coord", own.max_coord)):
            if not low - margin <= coordinate <= high + margin:
                reason = Message("the robot's description (URDF) ends before")
                shown = f"{coordinate:g} {own.unit}"
                key = f"{axis}/{end}"
                yield problem(faults.TRAVEL, AXES_FILE, key, shown, reason, allowed, doubtful=True)
    if not linear and not all(own.min_coord <= one <= own.max_coord for one in ROTATIONS_DEG):
        reason = Message("surveys turn the antennas to 0 and 90 degrees")
        yield problem(faults.TRAVEL, AXES_FILE, key, value, reason, allowed, doubtful=True)


def _check_motion(axis: str, own: AxisParameters) -> Iterator[Problem]:
    linear = own.type == AxisType.LINEAR.value
    coarsest = COARSEST_STEP_MM if linear else COARSEST_STEP_DEG
    if own.step_size > coarsest:
        reason = Message("no motor of this robot has such steps")
        allowed = f"0 - {coarsest:g} {own.unit}"
        shown = f"{own.step_size:g} {own.unit}"
        yield problem(faults.MOTION, AXES_FILE, f"{axis}/step_size", shown, reason, allowed)
        return
    fastest = FASTEST_MM_S if linear else FASTEST_DEG_S
    speed = own.step_size / (2.0 * own.min_step)
    key, value = f"{axis}/min_step", f"{own.min_step:g} s"
    least_s = own.step_size / (2.0 * fastest)
    if speed > fastest:
        reason = Message("the axis would move at {speed:.0f} {unit}/s", speed=speed, unit=own.unit)
        yield problem(faults.MOTION, AXES_FILE, key, value, reason, f">= {least_s:.3g} s")
    if 1.0 / (2.0 * own.max_step) > FASTEST_START_HZ:
        reason = Message(
            "the motor would start with {rate:.0f} steps per second", rate=0.5 / own.max_step
        )
        allowed, value = f">= {0.5 / FASTEST_START_HZ:g} s", f"{own.max_step:g} s"
        key = f"{axis}/max_step"
        yield problem(faults.MOTION, AXES_FILE, key, value, reason, allowed, doubtful=True)
    change = _largest_change(own)
    if change > FASTEST_CHANGE_PER_S2:
        reason = Message(
            "the axis would speed up by {change:.0f} {unit}/s in one second",
            change=change,
            unit=own.unit,
        )
        allowed = f"<= {FASTEST_CHANGE_PER_S2:.0f} {own.unit}/s2"
        shown, key = f"{own.delta_step:g} s", f"{axis}/delta_step"
        yield problem(faults.MOTION, AXES_FILE, key, shown, reason, allowed, doubtful=True)
    homing_s = 2.0 * own.max_step * own.travel_steps
    if homing_s > LONGEST_HOMING_S:
        reason = Message("its homing could take {hours:.1f} hours", hours=homing_s / 3600.0)
        allowed = f"<= {LONGEST_HOMING_S / 3600.0:g} h"
        shown, key = f"{own.step_size:g} {own.unit}", f"{axis}/step_size"
        yield problem(faults.MOTION, AXES_FILE, key, shown, reason, allowed, doubtful=True)


def _largest_change(own: AxisParameters) -> float:
    """Return the largest acceleration on the ramp, between its last two steps."""
    slower = min(own.max_step, own.min_step + own.delta_step)
    return own.step_size * (0.5 / own.min_step - 0.5 / slower) / (own.min_step + slower)
