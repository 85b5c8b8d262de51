"""Which nodes a client believes: those of its robot, or the player of a recording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Sequence, Tuple

from gpr20_common.low.clock import Clock
from gpr20_doctor.mid.node_health import EXPECTED_NODES, OPTIONAL_NODES

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
