"""What the main control reports about a survey, and the requests to it."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from typing import Dict, Iterator, Mapping, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, Severity, in_a_row
from gpr20_doctor.mid.node_health import EXPECTED_NODES, OPTIONAL_NODES
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import NodeDescription, RobotConfig
from gpr20_survey.plan.survey_parameters import (
    MAX_COORDINATE_MM,
    MIN_COORDINATE_MM,
    RobotTravel,
    SurveySettings,
    Travel,
)
from gpr20_survey.plan.survey_state import ENDED, SurveyState
from gpr20_survey.trace.utc_time import moment_text

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
    # Whether this is the recorded status of a replay.
    replay: bool = False
    # How the survey ended, until the next one begins; IDLE: it has not.
    end: SurveyState = SurveyState.IDLE

    @property
    def shown(self) -> SurveyState:
        """The state, or how the survey ended after which another plan was set."""
        return self.end if self.code is SurveyState.CONFIGURED and self.end in ENDED else self.code

    @property
    def title(self) -> Message:
        """What is shown, in a word; that of a replay says so."""
        label = self.shown.label
        return Message("REPLAY: {state}", state=label) if self.replay else label

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

    @property
    def axis_may_move(self) -> bool:
        """Whether an axis may still move although the survey has ended."""
        if self.code is not SurveyState.STOPPED:
            return self.message.may_move or self.is_fault
        # A text without a fault, or a code that came without the rest, does not say that all is
        # at rest.
        cause = self.message.cause
        known = cause is not None and not (
            cause.severity is Severity.FAULT and cause.remedy is None
        )
        return self.message.may_move or not known


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
    """Where the three axes move to; all three are -1 while no survey runs."""

    @property
    def is_none(self) -> bool:
        """Whether there is no target."""
        return self.x_mm == self.y_mm == self.z_deg == -1.0


@dataclass(frozen=True)
class MeasuredHeight:
    """Height of the antennas over the ground [m]; not finite if it was out of range."""

    height_m: float


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

    @property
    def travel(self) -> RobotTravel:
        """The limits of the axes."""
        return self.config.travel


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
class Accepted:
    """The main control accepted the parameters: size and duration of the survey."""

    total_points: int
    estimated_s: float


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


@dataclass(frozen=True)
class StopRequested:
    """The operator wants to stop the survey; `signal` is the name of the key or signal."""

    signal: str


class ReplayPhase(enum.IntEnum):
    """What a replay does; the values are those of gpr20_msgs/Replay."""

    PLAYING = 0
    PAUSED = 1
    ENDED = 2


@dataclass(frozen=True)
class PlayerLink:
    """Event: whether a player of recordings is connected; once a second."""

    connected: bool


@dataclass(frozen=True)
class Replay:
    """The last message of `replay`, and what is known besides; texts are empty if not known.

    Attributes:
        started: Start of the survey, ISO 8601, UTC.
        rate: How many times faster than it was recorded; 0: its player does not report it.
        connected: Whether its player is; None: none has been yet.
        state: The last state of the recorded survey; None before the first.
    """

    survey_id: str = ""
    started: str = ""
    folder: str = ""
    phase: ReplayPhase = ReplayPhase.PLAYING
    rate: float = 0.0
    connected: Optional[bool] = True
    state: Optional[SurveyState] = None

    @property
    def survey(self) -> Message:
        """The survey, for a sentence."""
        place = self.folder or self.survey_id[:8]
        if len(self.started) >= 16:
            time = moment_text(self.started[:16])
            return Message("Survey of {time} UTC, {folder}", time=time, folder=place)
        return Message("Survey {folder}", folder=place) if place else Message("Recorded survey")

    @property
    def ended(self) -> bool:
        """Whether nothing more will come."""
        return self.connected is False or self.phase is ReplayPhase.ENDED

    @property
    def paused(self) -> bool:
        """Whether it is paused and can continue."""
        return not self.ended and self.phase is ReplayPhase.PAUSED

    @property
    def can_pause(self) -> bool:
        """Whether its player takes requests: `rosbag play` takes none."""
        return not self.ended and self.rate > 0.0

    @property
    def title(self) -> Message:
        """What is shown where the state of a robot would be."""
        if self.ended:
            return Message("REPLAY ENDED")
        return Message("REPLAY PAUSED") if self.paused else Message("REPLAY")

    @property
    def message(self) -> Message:
        """The survey, and its state or how it ended."""
        if self.connected is None:
            return Message("Waiting for a recording.")
        if self.state is None:
            return self.survey
        if self.ended and self.state not in ENDED:
            return Message(
                "{state}, and the recording does not contain the survey's end. {survey}",
                state=self.state.label,
                survey=self.survey,
            )
        return Message("{state}. {survey}", state=self.state.label, survey=self.survey)


# Between two events about the same sender [s]: a recording has hundreds of messages a second.
NEWS_PERIOD_S = 1.0


@dataclass(frozen=True)
class SenderIgnored:
    """Event: a node that is none of the robot's speaks for it; nothing of that is shown."""

    sender: str


class Senders:
    """Decides by the name of its sender whether a message counts. Any thread may ask.

    The launch files fix the names of a robot's nodes, and of two nodes with one name the master
    ends the older. So whatever a recording contains, the name alone separates its player from a
    robot on the same topics.

    Args:
        namespace: Of the client, with slashes at both ends or alone.
        replay: Whether the client shows a replay: then nothing of a robot counts.
        clock: Measures the time between two events about a sender.
        nodes: The nodes of a robot that count.
    """

    def __init__(
        self,
        namespace: str,
        replay: bool = False,
        clock: Clock = Clock(),  # noqa: B008 (it has no state)
        nodes: Sequence[str] = (*EXPECTED_NODES, *OPTIONAL_NODES),
    ) -> None:
        self.namespace = namespace
        self.replay = replay
        self._clock = clock
        self._robot = frozenset(f"{namespace}{node}" for node in nodes)
        self._noted_s: Dict[str, float] = {}

    def takes(self, sender: str) -> bool:
        """Return whether the messages of a node count."""
        return (sender in self._robot) is not self.replay

    def note_ignored(self, sender: str) -> Tuple[bool, bool]:
        """Note a message that does not count; return whether to report it, and to log it."""
        now_s, noted_s = self._clock.now_s(), self._noted_s.get(sender, -math.inf)
        due = not self.replay and now_s - noted_s >= NEWS_PERIOD_S
        if due:
            self._noted_s[sender] = now_s
        return due, due and noted_s == -math.inf
