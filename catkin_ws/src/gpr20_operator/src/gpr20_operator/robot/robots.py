"""The robots that share a ROS master, of which the window shows one."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import singledispatchmethod
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
    """A robot that the window can show.

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
        if self.state is None:
            return Message("no report yet")
        return self.state.title

    @property
    def condition(self) -> Optional[Condition]:
        """How it goes, by its state alone, which is heard now; None: it has not said so yet."""
        if self.state is None:
            return None
        return condition_of(Snapshot(True, 0.0, self.state))


@dataclass
class Robots:
    """The robots that were found, and what they do.

    Args:
        own: Namespace of the robot that the window shows.
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

    @singledispatchmethod
    def take(self, _event: object) -> None:
        """Take an event; most are about something else."""

    @take.register
    def _(self, event: RobotsFound) -> None:
        self._found = event.namespaces

    @take.register
    def _(self, event: RobotReported) -> None:
        self._states[event.namespace] = event.state

    @property
    def shown(self) -> ListedRobot:
        """The robot that the window shows."""
        return ListedRobot(self.own, self._states.get(self.own), True)

    @property
    def are_several(self) -> bool:
        """Whether an operator could take one robot for another."""
        return bool(self._found - {self.own})

    @property
    def can_choose(self) -> bool:
        """Whether there is another robot to show."""
        return self.may_choose and self.are_several

    @property
    def listed(self) -> Tuple[ListedRobot, ...]:
        """All robots in the order of their names."""
        return tuple(
            ListedRobot(one, self._states.get(one), one == self.own) for one in sorted(self._found)
        )

    def must_choose(self, control_seen: bool, open_s: float) -> bool:
        """Return whether there is no robot in the window's namespace, but another one."""
        missing = self.own not in self._found and not control_seen and open_s > STARTING_S
        return self.can_choose and missing
