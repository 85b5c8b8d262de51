"""What no program can find out about the wiring of a robot, and a person must check."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Mapping, Tuple

from gpr20_common.message import Message


class Unchecked(enum.Enum):
    """Something that must be checked before anything may move."""

    UNREAD = "unread"
    PINS = "pins"
    Z_DIRECTION_OR_STEP = "z_direction_or_step"
    ENDSTOP_LEVELS = "endstop_levels"
    DIRECTIONS = "directions"
    NO_5_V = "no_5_v"
    TRAVEL = "travel"
    EMERGENCY_STOP = "emergency_stop"


@dataclass(frozen=True)
class Wiring:
    """What is not checked yet.

    Attributes:
        unchecked: Delete each word when a person has checked it, as docs/wiring.md describes. With
            unread, pins, z_direction_or_step, no_5_v or endstop_levels in the list the robot is
            not launched; with emergency_stop, directions or travel it warns.
    """

    unchecked: Tuple[Unchecked, ...] = ()


# They are checked with the robot running, by the steps of the first power-up.
WITH_ROBOT = (Unchecked.EMERGENCY_STOP, Unchecked.DIRECTIONS, Unchecked.TRAVEL)
TASKS: Mapping[Unchecked, Message] = {
    Unchecked.UNREAD: Message(
        "find out what the old launch files set at the places that the comments of wiring.yaml "
        "name, and enter it into axes.yaml"
    ),
    Unchecked.PINS: Message(
        "with everything switched off, follow each pin of axes.yaml and height.yaml to its driver, "
        "switch or converter with a continuity meter"
    ),
    Unchecked.Z_DIRECTION_OR_STEP: Message(
        "with everything switched off, find out with a continuity meter which of the two pins of z "
        "leads to STEP of its drivers; the other one leads to DIR"
    ),
    Unchecked.ENDSTOP_LEVELS: Message(
        "measure the level of each endstop's signal while it is pressed, and with its wire off"
    ),
    Unchecked.DIRECTIONS: Message(
        "home each axis with one hand on the emergency stop: if it moves away from its endstop, "
        "press it and change invert_direction"
    ),
    Unchecked.NO_5_V: Message(
        "measure that no signal at the header of the Raspberry Pi can exceed 3.3 V"
    ),
    Unchecked.TRAVEL: Message("measure how far each carriage can move from its endstop"),
    Unchecked.EMERGENCY_STOP: Message(
        "test that the emergency stop cuts the supply of all motors, 9 V and 3.3 V"
    ),
}
