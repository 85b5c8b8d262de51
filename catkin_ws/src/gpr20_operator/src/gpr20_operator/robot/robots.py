"""The robots that share a ROS master, of which a screen shows one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Dict, FrozenSet, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.robot.condition import Condition, condition_of
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.snapshot import Snapshot

# A robot that is starting is not yet a missing one [s].
STARTING_S = 5.0


@dataclass(frozen=True)
class RobotsFound:
    """Event: the namespaces of all robots on the master."""

    namespaces: FrozenSet[str]


@dataclass(frozen=True)
class RobotReported:
    """Event: what a robot says about its survey."""

    namespace: str
    state: ControlState


@dataclass(frozen=True)
class ListedRobot:
    """A robot that a screen can show.

    Attributes:
        namespace: Its namespace, with a slash in front.
        state: What it does; None: it has not said so yet.
    """

    namespace: str
    state: Optional[ControlState]
    is_shown: bool

    @property
    def name(self) -> str:
        """The namespace as a person reads it; that of a robot without one is "/"."""
        return self.namespace.strip("/") or "/"

    def short_name(self, longest: int) -> str:
        """Return the name in at most so many letters; the end of names differs most often."""
        name = self.name
        return name if len(name) <= longest else f"…{name[1 - longest :]}"

    @property
    def activity(self) -> Message:
        """What it does, in a word."""
        return Message("no report yet") if self.state is None else self.state.title

    @property
    def condition(self) -> Optional[Condition]:
        """How it goes, by its state alone, which is heard now; None: it has not said so yet."""
        return None if self.state is None else condition_of(Snapshot(True, 0.0, self.state))


@dataclass
class Robots:
    """The robots that were found, and what they do.

    Args:
        own: Namespace of the robot that the screen shows.
        watch: Begins or ends to listen to what each robot does.
        show: Shows the robot of a namespace in place of this one.
    """

    own: str
    may_choose: bool = True
    watch: Callable[[bool], None] = lambda _watched: None
    show: Callable[[str], None] = lambda _namespace: None
    _found: FrozenSet[str] = frozenset()
    _states: Dict[str, ControlState] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.own = "/" + self.own.strip("/")

    def take(self, event: object) -> None:
        """Take an event; most are about something else."""
        if isinstance(event, RobotsFound):
            self._found = event.namespaces
        elif isinstance(event, RobotReported):
            self._states[event.namespace] = event.state

    @property
    def shown(self) -> ListedRobot:
        """The robot that the screen shows."""
        return self._robot(self.own)

    @property
    def listed(self) -> Tuple[ListedRobot, ...]:
        """All robots in the order of their names."""
        return tuple(map(self._robot, sorted(self._found)))

    @property
    def are_several(self) -> bool:
        """Whether an operator could take one robot for another."""
        return bool(self._found - {self.own})

    @property
    def can_choose(self) -> bool:
        """Whether there is another robot to show."""
        return self.may_choose and self.are_several

    def must_choose(self, control_seen: bool, open_s: float) -> bool:
        """Return whether there is no robot in the window's namespace, but another one."""
        missing = self.own not in self._found and not control_seen and open_s > STARTING_S
        return self.can_choose and missing

    def _robot(self, namespace: str) -> ListedRobot:
        return ListedRobot(namespace, self._states.get(namespace), namespace == self.own)
