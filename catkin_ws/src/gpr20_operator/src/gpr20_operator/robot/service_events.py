"""What happens in the service of the robot, the answers to requests, and what is shown."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Optional, Tuple

from gpr20_common.message import Message
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import Part


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


PARTS = tuple(Part)


@dataclass(frozen=True)
class DailyCheckState:
    """Where the daily check is.

    Attributes:
        part: What is to be measured next, or is measured now; None: no check is in progress.
        answer: The verdict, or why the last step failed; None: there is neither.
        measuring: Whether a step is in progress.
    """

    part: Optional[Part] = None
    answer: Optional[CheckStepTaken] = None
    measuring: bool = False

    def after(self, answer: CheckStepTaken) -> DailyCheckState:
        """Return where the check is after the answer to a step."""
        if not answer.success:
            # A step that failed is repeated, unless the robot has forgotten those before it.
            forgotten = answer.message.fault_code == CHECK_ORDER.code
            return DailyCheckState(None if forgotten else self.part, answer)
        if self.part is None or self.part is PARTS[-1]:
            return DailyCheckState(None, answer)
        return DailyCheckState(PARTS[PARTS.index(self.part) + 1])


@dataclass(frozen=True)
class AxisState:
    """What is known about an axis.

    Attributes:
        axis: Which axis.
        coordinate: Where it is [mm or deg]; None: not known.
        homed: Whether its zero is known; None: not known now.
        pressed: Whether its endstop is pressed; None: not known now, or there is none.
    """

    axis: AxisId
    coordinate: Optional[float]
    homed: Optional[bool]
    pressed: Optional[bool]


@dataclass(frozen=True)
class ServiceState:
    """What SERVICE shows.

    Attributes:
        entered: Whether the axes may be moved.
        obstacle: Why the robot cannot be serviced now; None: it can.
        busy: Whether a request is in progress.
        outcome: The last answer about an axis, or what is done now; None: there was none.
        failed: Whether the last answer was a failure.
        axes: X, Y and Z.
        height: The last height; None: none was measured.
        analyzer: The last test of the VNA; None: there was none.
        examining: Whether everything is being checked.
        daily_check: Where the daily check is.
    """

    entered: bool
    obstacle: Optional[Message]
    busy: bool
    outcome: Optional[Message]
    failed: bool
    axes: Tuple[AxisState, ...]
    height: Optional[HeightTested]
    analyzer: Optional[AnalyzerTest]
    examining: bool = False
    daily_check: DailyCheckState = field(default_factory=DailyCheckState)
