"""Whether a message comes from a robot or from a replay."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Set

from gpr20_survey.axes.axis_id import AxisId

# How `rosbag play`, whose older recordings hold no mark, and replay.launch name their nodes. The
# mark of a replay may come after its other messages.
PLAYERS = re.compile(r".*/(play_[0-9]+|replay)")


@dataclass(frozen=True)
class Received:
    """An event, and the full name of the node that sent it."""

    source: str
    event: object


@dataclass(frozen=True)
class SourceGone:
    """A node that sent messages does not answer any more."""

    source: str


def is_player(source: str) -> bool:
    """Return whether a node has the name of a player of recordings."""
    return PLAYERS.fullmatch(source) is not None


class MessageSources:
    """Knows which nodes replay a recording.

    A node does if it sends the mark `replay`, or has the name of a player. A mark says something
    about its own sender alone, and nothing about the main control of a robot: it cannot make a
    robot look like a replay. Any other node counts as a robot's.

    Args:
        main_control: Full name of the robot's main control.
    """

    def __init__(self, main_control: str) -> None:
        self.main_control = main_control
        self._marked: Set[str] = set()

    def axis_driver(self, axis: AxisId) -> str:
        """Return the full name of the robot's driver of an axis."""
        return f"{self.main_control.rpartition('/')[0]}/{axis.value}_axis/axis_driver"

    def note_mark(self, source: str) -> bool:
        """Note that a node sent a mark; return whether this is news about it."""
        if self.is_replay(source) or source == self.main_control:
            return False
        self._marked.add(source)
        return True

    def is_replay(self, source: str) -> bool:
        """Return whether a node replays a recording."""
        if source == self.main_control:
            return False
        return source in self._marked or is_player(source)
