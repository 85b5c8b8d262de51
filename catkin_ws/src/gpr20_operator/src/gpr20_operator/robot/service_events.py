"""What happens on SERVICE: states of the robot, and answers to requests."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_survey.axes.axis_id import AxisId


class AxisAction(enum.IntEnum):
    """What an axis can be asked for; the values are those of gpr20_msgs/ServiceMove."""

    HOME = 0
    JOG = 1
    SET_ZERO = 2


@dataclass(frozen=True)
class ServiceActivity:
    """One message of `service_status`: what is done for maintenance; None: nothing."""

    activity: Optional[Message]


@dataclass(frozen=True)
class EndstopState:
    """One message of an axis's `endstop`."""

    axis: AxisId
    pressed: bool


@dataclass(frozen=True)
class AxisMeasured:
    """One message of an axis's `current_coord`.

    Attributes:
        axis: Which axis.
        position: Its state.
        owner: Full name of the node that holds it; empty: nobody, or it is not known.
    """

    axis: AxisId
    position: AxisPosition
    owner: str = ""


@dataclass(frozen=True)
class ClockOffset:
    """How far the clock of a node's computer is behind the window's, with the delay [s]."""

    node: str
    offset_s: float


@dataclass(frozen=True)
class MachineExamined:
    """What is known about the window's computer."""

    machine: MachineFacts


@dataclass(frozen=True)
class AxisMoved:
    """The answer to a request for an axis."""

    success: bool
    message: Message


@dataclass(frozen=True)
class CheckStepTaken:
    """The answer to a step of the daily check.

    Attributes:
        success: Whether its part was swept.
        message: After the last part the verdict; or what failed.
        good: After the last part: whether nothing differs.
    """

    success: bool
    message: Message
    good: bool = False


@dataclass(frozen=True)
class HeightTested:
    """One height of the height sensor.

    Attributes:
        height_m: Antennas over the ground [m]; not finite if there is a failure.
        spread_m: Of its readings [m].
        voltage_v: Of the sensor [V]; not finite if it could not be read.
        failure: Why there is no height; None if there is one.
    """

    height_m: float
    spread_m: float
    voltage_v: float
    failure: Optional[Message] = None
