"""What the main control reports about a survey, and the requests to it."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Iterator, Mapping, Optional, Protocol, Sequence

from gpr20_common.message import Message, Severity, in_a_row
from gpr20_doctor.mid.node_health import EXPECTED_NODES, OPTIONAL_NODES
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.annotation import EMPTY, Annotation, Site
from gpr20_survey.plan.robot_description import NodeDescription, RobotConfig
from gpr20_survey.plan.survey_parameters import (
    MAX_COORDINATE_MM,
    MIN_COORDINATE_MM,
    RobotTravel,
    SurveyParameters,
    SurveySettings,
    Travel,
)
from gpr20_survey.plan.survey_state import ENDED, SurveyState

# The limits of the documented system, for as long as the axes' own are not known:
# the main control, which knows them, refuses what lies between the two.
DOCUMENTED_TRAVEL = RobotTravel(
    x=Travel(MIN_COORDINATE_MM, MAX_COORDINATE_MM, 0.01),
    y=Travel(MIN_COORDINATE_MM, MAX_COORDINATE_MM, 0.01),
    z=Travel(-90.0, 90.0, 1.8),
)


@dataclass(frozen=True)
class ControlState:
    """One message of `control_status`."""

    code: SurveyState
    message: Message
    survey_id: str
    simulated: bool
    # How the survey ended, until the next one begins; IDLE: it has not.
    end: SurveyState = SurveyState.IDLE

    @property
    def shown(self) -> SurveyState:
        """The state, or how the survey ended after which another plan was set."""
        return self.end if self.code is SurveyState.CONFIGURED and self.end in ENDED else self.code

    @property
    def reason(self) -> Message:
        """What it says without the words around it that name the state, unless that may move."""
        failed = tuple(_failed(self.message)) or (self.message,)
        found = failed[0] if len(failed) == 1 else in_a_row(failed)
        return found if found.may_move == self.message.may_move else self.message

    @property
    def is_fault(self) -> bool:
        """Whether a survey is paused or has ended because of a fault."""
        failed = self.message.severity is Severity.FAULT
        if self.code is SurveyState.PAUSED:
            # A text that does not say that the pause was asked for, as one of another version,
            # is a fault; a warning alone does not say it.
            asked = any(one.severity is Severity.NOTE for one in self.message.faults)
            return failed or not asked
        return self.code is SurveyState.FAILED or (failed and self.code is SurveyState.STOPPED)


def _failed(message: Message) -> Iterator[Message]:
    """Yield the outermost sentences inside a message that report a failure."""
    for one in message.inner():
        if one.fault is not None and one.fault.severity is Severity.FAULT:
            yield one
        else:
            yield from _failed(one)


@dataclass(frozen=True)
class Progress:
    """One message of `control_survey_data`; a point is one trace."""

    survey_id: str
    completion_percent: float
    total_points: int
    visited_points: int
    remaining_s: float


@dataclass(frozen=True)
class Position:
    """A place of the antennas."""

    x_mm: float
    y_mm: float
    z_deg: float


class CurrentPosition(Position):
    """Where the three axes are."""


class TargetPosition(Position):
    """Where the three axes move to."""


@dataclass(frozen=True)
class Configured:
    """What is known of a robot whose nodes have all described themselves.

    Attributes:
        config: Its axes; the estimate of a survey's time is based on them and the settings.
        site: Place and operator that it proposes.
        vna_address: The address that it proposes.
    """

    config: RobotConfig
    settings: SurveySettings
    site: Site
    vna_address: str


@dataclass(frozen=True)
class RobotDescribed:
    """One message of `robot_configuration`.

    Attributes:
        robot: None: not everything is known.
        reason: Why not.
        nodes: What each node says.
    """

    robot: Optional[Configured] = None
    reason: Optional[Message] = None
    nodes: Mapping[str, NodeDescription] = field(default_factory=dict)


@dataclass(frozen=True)
class MasterAnswered:
    """Whether the ROS master has answered."""

    alive: bool


@dataclass(frozen=True)
class ServiceActivity:
    """One message of `service_status`: what is done for maintenance; None: nothing."""

    activity: Optional[Message]


class Request(enum.Enum):
    """What the main control can be asked for."""

    START = "start"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"


@dataclass(frozen=True)
class StartPlan:
    """What START measures.

    Attributes:
        annotation: What people add to the survey; empty fields become the robot's defaults.
        refines: Id of the survey that it measures more finely; empty: none.
        permittivity: Relative permittivity of the ground; 0: not known.
    """

    parameters: SurveyParameters
    annotation: Annotation = EMPTY
    refines: str = ""
    permittivity: float = 0.0


@dataclass(frozen=True)
class Answer:
    """How a request ended: the answer of the main control, or that there was none.

    Attributes:
        survey_id: Of the survey that begins; empty if none does.
        other_analyzer: Identity of the present analyzer, if it is not that of the survey, which
            is resumed only if the operator accepts it; else empty.
        contact: Whether the main control has answered.
    """

    request: Request
    success: bool
    message: Message
    survey_id: str = ""
    other_analyzer: str = ""
    contact: bool = True


@dataclass(frozen=True)
class AxisStopAnswer:
    """Whether an axis has answered STOP in time."""

    axis: AxisId
    answered: bool


class SurveyControl(Protocol):
    """Requests to the main control, without waiting; the answers come as events."""

    def start_survey(self, plan: StartPlan) -> None:
        """Ask to accept the parameters and to start."""

    def stop(self) -> None:
        """Ask whatever moves to stop, whoever moves it."""

    def withdraw_start(self) -> None:
        """Keep a survey from starting whose parameters have not been accepted yet."""

    def pause_survey(self) -> None:
        """Ask to pause the survey."""

    def resume_survey(
        self, survey_id: str = "", accept_analyzer: str = "", accept_zeros: bool = False
    ) -> None:
        """Ask to resume the paused survey, or one by its id or the name of its folder."""

    def check_master(self) -> None:
        """Check that the master answers; the answer is an event."""


REPLAY = Message("REPLAY")


@dataclass(frozen=True)
class Replay:
    """One message of `replay`: what is shown where the state of a robot would be."""

    title: Message = REPLAY


@dataclass(frozen=True)
class Senders:
    """Decides by the name of its sender whether a message counts.

    The launch files fix the names of a robot's nodes, and of two nodes with one name the master
    ends the older. So whatever a recording contains, the name alone separates its player from a
    robot on the same topics.

    Attributes:
        namespace: Of the client, with slashes at both ends or alone.
        replay: Whether the client shows a replay: then nothing of a robot counts.
        nodes: The nodes of a robot that count.
    """

    namespace: str
    replay: bool = False
    nodes: Sequence[str] = (*EXPECTED_NODES, *OPTIONAL_NODES)

    def takes(self, sender: str) -> bool:
        """Return whether the messages of a node count."""
        begin = self.namespace
        own = sender.startswith(begin) and sender[len(begin) :] in self.nodes
        return own is not self.replay
