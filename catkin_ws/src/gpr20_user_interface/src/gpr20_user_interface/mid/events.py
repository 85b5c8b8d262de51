"""What main_control says about a survey, and what it is asked for."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Mapping, Optional, Union

from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_parameters import (
    MAX_COORDINATE_MM,
    MIN_COORDINATE_MM,
    RobotTravel,
    SurveyParameters,
    Travel,
)
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState

# The limits of the documented system, for as long as the axes' own are not known:
# main_control, which knows them, refuses what lies between the two.
DOCUMENTED_TRAVEL = RobotTravel(
    x=Travel(MIN_COORDINATE_MM, MAX_COORDINATE_MM, 0.01),
    y=Travel(MIN_COORDINATE_MM, MAX_COORDINATE_MM, 0.01),
    z=Travel(-90.0, 90.0, 1.8),
)


@dataclass(frozen=True)
class ControlState:
    """One message of `control_status`."""

    code: SurveyState
    message: str
    survey_id: str
    simulated: bool


@dataclass(frozen=True)
class Progress:
    """One message of `control_survey_data`; a point is one trace."""

    survey_id: str
    completion_percent: float
    total_points: int
    visited_points: int
    remaining_s: float

    @property
    def is_complete(self) -> bool:
        """Whether every trace is taken."""
        return self.visited_points >= self.total_points > 0


@dataclass(frozen=True)
class Position:
    """A place of the antennas."""

    x_mm: float
    y_mm: float
    z_deg: float


class CurrentPosition(Position):
    """Where the three axes are."""


class TargetPosition(Position):
    """Where the three axes go; all three are -1 while no survey runs."""

    @property
    def is_none(self) -> bool:
        """Whether this says that there is no target."""
        return self.x_mm == self.y_mm == self.z_deg == -1.0


@dataclass(frozen=True)
class MeasuredHeight:
    """Height of the antennas over the ground [m]; not finite if it was out of range."""

    height_m: float


@dataclass(frozen=True)
class RobotFigures:
    """What the estimate of a survey's time and size rests on."""

    config: RobotConfig
    settings: SurveySettings


@dataclass(frozen=True)
class AxisLimits:
    """What the axes say they can do; without a travel the reason says why it is not known.

    Attributes:
        travel: Ranges and steps; None if they are not known.
        reason: Why something is not known.
        figures: Everything else about the robot; None if it is not known.
        master_alive: Whether the ROS master answered.
    """

    travel: Optional[RobotTravel]
    reason: str = ""
    figures: Optional[RobotFigures] = None
    master_alive: bool = True


@dataclass(frozen=True)
class ControlParameters:
    """The parameters that main_control holds: of the survey that runs, or of the next."""

    parameters: SurveyParameters


class HealthLevel(enum.IntEnum):
    """How a part of the robot is; the values are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class NodeHealth:
    """What a node says of itself on /diagnostics, once a second."""

    name: str
    level: HealthLevel
    message: str
    values: Mapping[str, str]


class Request(enum.Enum):
    """What main_control can be asked for."""

    START = "start"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"


@dataclass(frozen=True)
class Accepted:
    """main_control accepted the parameters; what the survey will be."""

    total_points: int
    estimated_s: float


@dataclass(frozen=True)
class Answer:
    """How a request ended: what main_control answered, or that it did not."""

    request: Request
    success: bool
    message: str
    survey_id: str = ""


@dataclass(frozen=True)
class StopRequested:
    """The operator wants the survey stopped."""

    reason: str


# Everything that can happen to somebody who follows a survey.
Event = Union[
    ControlState,
    Progress,
    CurrentPosition,
    TargetPosition,
    MeasuredHeight,
    AxisLimits,
    ControlParameters,
    NodeHealth,
    Accepted,
    Answer,
    StopRequested,
]
