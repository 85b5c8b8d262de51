"""Ending nodes that are alive but answer nothing, so that roslaunch restarts them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Collection, Dict, Mapping, Optional, Protocol, Set

from gpr20_common.low.clock import Clock
from gpr20_launch.low.node_answer import Answer

# Time between two rounds of requests, and for the answer to each [s].
PERIOD_S = 2.0
ANSWER_LIMIT_S = 2.0
# A node that has never answered may still be starting [s].
MUTE_LIMIT_S = 60.0
# A node that uses the processor may be long at work: it gets this many times the limit.
WORKING_FACTOR = 6.0
# A round that begins this much late [s] shows that the computer itself was held up.
STALL_S = 2.0
# roslaunch restarts a node within seconds; one that is missing for this long stays away [s].
RESPAWN_LIMIT_S = 60.0


class Nodes(Protocol):
    """The nodes of one launch on this computer, as processes."""

    def find(self) -> Mapping[int, str]:
        """Return the full name of each node, by its process id."""

    def ask(self, number: int, name: str) -> Answer:
        """Return whether it answers."""

    def is_working(self, number: int) -> bool:
        """Return whether it uses the processor or a disk, or waits for them."""

    def is_traced(self, number: int) -> bool:
        """Return whether a debugger is attached to it."""

    def kill(self, number: int, name: str) -> None:
        """End it."""


@dataclass
class _Silence:
    """A node does not answer.

    Attributes:
        since_s: When the first request without an answer was made [s].
        works: Whether the process was seen working since.
    """

    since_s: float
    works: bool = False


class Watchdog:
    """Asks every node in turn, and kills one that has been silent for too long."""

    def __init__(
        self,
        nodes: Nodes,
        limit_s: float,
        clock: Clock,
        say: Callable[[str], None],
        spared: Collection[str] = (),
    ) -> None:
        """Know nothing yet.

        Args:
            nodes: The nodes.
            limit_s: How long a node may be silent [s].
            clock: Measures it.
            say: Prints a line.
            spared: Full names of the nodes without which the launch is complete: they are ended
                if they hang, but no survey is interrupted because one stays away.
        """
        self._nodes = nodes
        self._limits_s = {Answer.SILENT: limit_s, Answer.MUTE: max(limit_s, MUTE_LIMIT_S)}
        self._clock = clock
        self._say = say
        self._spared = frozenset(spared)
        self._silences: Dict[int, _Silence] = {}
        self._missing_since_s: Dict[str, Optional[float]] = {}
        self._due_s = clock.now_s()

    def look(self) -> None:
        """Ask every node once; to be called every PERIOD_S."""
        if self._clock.now_s() > self._due_s + STALL_S:
            # What kept this process from running may have kept the nodes from answering.
            self._silences.clear()
        found = self._nodes.find()
        for number in set(self._silences) - set(found):
            del self._silences[number]
        self._note_missing(set(found.values()) - self._spared)
        for number, name in found.items():
            self._look_at(number, name)
        self._due_s = self._clock.now_s() + PERIOD_S

    @property
    def complete(self) -> bool:
        """Whether roslaunch has restarted every node that ended."""
        now_s = self._clock.now_s()
        missing = [since_s for since_s in self._missing_since_s.values() if since_s is not None]
        return all(now_s - since_s < RESPAWN_LIMIT_S for since_s in missing)

    def _note_missing(self, names: Set[str]) -> None:
        for name in {*names, *self._missing_since_s}:
            since_s = self._missing_since_s.get(name)
            missing_s = self._clock.now_s() if since_s is None else since_s
            self._missing_since_s[name] = None if name in names else missing_s

    def _look_at(self, number: int, name: str) -> None:
        asked_s = self._clock.now_s()
        answer = self._nodes.ask(number, name)
        limit_s = self._limits_s.get(answer)
        works = limit_s is not None and self._nodes.is_working(number)
        # One that computes before its first answer is starting.
        if limit_s is None or (works and answer is Answer.MUTE):
            self._silences.pop(number, None)
            return
        silence = self._silences.setdefault(number, _Silence(asked_s))
        silence.works |= works
        silent_s = self._clock.now_s() - silence.since_s
        if silent_s < limit_s * (WORKING_FACTOR if silence.works else 1.0):
            return
        if not self._nodes.is_traced(number):
            self._say(f"{name} (process {number}) did not answer for {silent_s:.0f} s: ended")
            self._nodes.kill(number, name)
