"""What no program can find out about the wiring of a robot, and a person must check."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Tuple


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
    """What a person must still check on this robot.

    Attributes:
        unchecked: Delete each word when a person has checked it, as docs/wiring.md describes. With
            unread, pins, z_direction_or_step, no_5_v or endstop_levels in the list the robot is
            not launched; with emergency_stop, directions or travel it warns.
    """

    unchecked: Tuple[Unchecked, ...] = ()


# They are checked with the robot running, by the steps of the first power-up.
WITH_ROBOT = (Unchecked.EMERGENCY_STOP, Unchecked.DIRECTIONS, Unchecked.TRAVEL)
