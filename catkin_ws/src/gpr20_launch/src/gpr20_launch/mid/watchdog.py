"""Ending nodes that are alive but answer nothing, so that roslaunch restarts them."""

from __future__ import annotations

from typing import Callable, Dict, Tuple

from gpr20_common.low.clock import Clock
from gpr20_launch.low.launched_nodes import LaunchedNodes

# Time between two rounds of requests [s].
PERIOD_S = 2.0
# A node that uses the processor may be long at work: it gets this many times the limit.
WORKING_FACTOR = 6.0
# A round that begins this much late [s] shows that the computer itself was held up.
STALL_S = 2.0


class Watchdog:
    """Asks every node in turn, and kills one that has been silent for too long."""

    def __init__(
        self, nodes: LaunchedNodes, limit_s: float, clock: Clock, say: Callable[[str], None]
    ) -> None:
        """Know nothing yet; a node may be silent for the limit [s]."""
        self._nodes = nodes
        self._limit_s = limit_s
        self._clock = clock
        self._say = say
        # Of each process without an answer: since when [s], and whether it was seen working.
        self._silences: Dict[int, Tuple[float, bool]] = {}
        self._due_s = clock.now_s()

    def look(self) -> None:
        """Ask every node once; to be called every PERIOD_S."""
        if self._clock.now_s() > self._due_s + STALL_S:
            # What kept this process from running may have kept the nodes from answering.
            self._silences.clear()
        found = self._nodes.find()
        for number in set(self._silences) - set(found):
            del self._silences[number]
        for number, name in found.items():
            self._look_at(number, name)
        self._due_s = self._clock.now_s() + PERIOD_S

    def _look_at(self, number: int, name: str) -> None:
        asked_s = self._clock.now_s()
        if self._nodes.answers(number, name) is not False:
            self._silences.pop(number, None)
            return
        since_s, works = self._silences.get(number, (asked_s, False))
        works = works or self._nodes.is_working(number)
        self._silences[number] = since_s, works
        silent_s = self._clock.now_s() - since_s
        if silent_s >= self._limit_s * (WORKING_FACTOR if works else 1.0):
            self._say(f"{name} (process {number}) did not answer for {silent_s:.0f} s: ended")
            self._nodes.kill(number, name)
