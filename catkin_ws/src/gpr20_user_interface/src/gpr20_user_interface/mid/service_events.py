"""What happens on SERVICE: states of the robot, and answers to requests."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message
from gpr20_doctor.mid.machine_facts import MachineFacts
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


@dataclass(frozen=True)
class AnalyzerTested:
    """What a test of the VNA has found, up to its first failure.

    Attributes:
        address: Where the VNA was looked for.
        identity: What it says it is; empty: no connection.
        calibration: Name of its calibration status; empty: not read, or not accepted.
        points: Frequencies of the sweep; 0: there was none.
        sweep_duration_s: From the trigger to the end of the sweep [s].
        level_db: Median of S21 [dB].
        failure: What failed; None: nothing.
    """

    address: str
    identity: str
    calibration: str
    points: int
    sweep_duration_s: float
    level_db: float
    failure: Optional[Message] = None
