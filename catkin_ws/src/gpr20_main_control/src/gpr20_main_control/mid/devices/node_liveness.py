"""Which nodes of the robot are running."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.faults import PART_SILENT
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import NodeLostError

# Nodes that are launched together are all running after this time [s].
START_LIMIT_S = 15.0
# The end of a process is noticed after one period, at most: its address refuses connections.
PERIOD_S = 0.9
# A node that does not answer for this time hangs, or the link to it is down [s]. Over a link
# that loses packets, a single answer may take seconds.
SILENCE_LIMIT_S = 5.0
REFRESH_LIMIT_S = SILENCE_LIMIT_S + 1.0
# Connections to each node: while one waits for a lost packet, the others continue to ask.
CONNECTIONS = 3
# Threads that ask: at least two more than there are nodes. A node that hangs holds one for each of
# its connections, but never the last: that one is for nodes that hold none.
WATCHERS = 9


@dataclass(frozen=True)
class WatchedNode:
    """A node that a survey needs.

    Attributes:
        plain_name: What operators call it.
        probes: Each returns the number of the node's process over a connection of its own, or
            raises NodeSilentError.
    """

    plain_name: Message
    probes: Sequence[Callable[[], int]]


@dataclass
class _Known:
    """What is known about a node.

    Attributes:
        named: Its names, for a message.
        free: The probes that wait for no answer.
        asking: How many probes wait for one.
        process: The number of its process; None if the node does not answer.
        accepted: The process with which the survey continues.
        seen: Whether it ever answered.
        answered_s: When it answered last [s].
        due_s: When the next poll begins [s].
        polls: How many polls have begun.
        result: The last of these polls that had a result; earlier ones say nothing new.
    """

    named: Dict[str, object]
    free: List[Callable[[], int]]
    asking: int = 0
    process: Optional[int] = None
    accepted: Optional[int] = None
    seen: bool = False
    answered_s: float = 0.0
    due_s: float = 0.0
    polls: int = 0
    result: int = 0


class NodeLiveness:
    """Polls the nodes and stores the last answer of each.

    A node is missing if its process has ended, or if it has not answered on any connection for
    SILENCE_LIMIT_S. Every method may be called from any thread.
    """

    def __init__(
        self,
        nodes: Mapping[str, WatchedNode],
        clock: Clock,
        on_change: Callable[[Optional[Message]], None],
        period_s: float = PERIOD_S,
    ) -> None:
        """Begin with nodes whose state is unknown; `start` begins to poll them.

        Args:
            nodes: The nodes that a survey needs, by their names on the ROS graph.
            clock: Measures the time that nodes have to start and to answer.
            on_change: Called with a message about the nodes that do not answer, or with None
                when all of them answer.
            period_s: Time between two polls of a node [s].
        """
        self._clock = clock
        self._on_change = on_change
        self._period_s = period_s
        # Conditions share a lock: an answer wakes only the threads that wait for it.
        lock = threading.RLock()
        self._changed, self._due = threading.Condition(lock), threading.Condition(lock)
        # One thread waits for the next poll; the others are spare while polls have no answer.
        self._turn = threading.Lock()
        self._known: Dict[str, _Known] = {}
        self._reported: Optional[Message] = None
        self._starting_until_s = clock.now_s() + START_LIMIT_S
        self._ended = False
        for name, node in nodes.items():
            self.watch(name, node)

    def start(self) -> None:
        for _one in range(WATCHERS):
            threading.Thread(target=self._watch, name="node watch", daemon=True).start()

    def watch(self, name: str, node: WatchedNode) -> None:
        """Poll one more node, which is noted as silent at first; a node that is polled stays.

        The processes that a survey accepted before do not include it: nothing is lost.
        """
        with self._changed:
            if name not in self._known:
                named = {"node": node.plain_name, "details": name}
                self._known[name] = _Known(named, list(node.probes))
                self._due.notify_all()

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            self._due.notify_all()

    def refresh(self) -> None:
        """Poll every node now; return when all have answered or are known to be missing."""
        with self._changed:
            before = {name: known.polls for name, known in self._known.items()}
            for known in self._known.values():
                known.due_s = self._clock.now_s()
            self._due.notify_all()
            self._changed.wait_for(
                lambda: all(self._known[name].result > polls for name, polls in before.items()),
                REFRESH_LIMIT_S,
            )
            for name in before:
                self.note_late(name)

    def note_alive(self, name: str, process: int) -> None:
        """Note that a node has answered, and the number of its process."""
        with self._changed:
            known = self._known[name]
            known.process, known.seen = process, True
            known.answered_s = self._clock.now_s()
            self._report_missing()

    def note_silent(self, name: str) -> None:
        """Note that a node does not answer: its process has ended, or it hangs."""
        with self._changed:
            self._known[name].process = None
            self._report_missing()

    def note_late(self, name: str) -> None:
        """Note that one answer of a node did not come in time."""
        with self._changed:
            known = self._known[name]
            if self._clock.now_s() - known.answered_s > SILENCE_LIMIT_S:
                known.process = None
            self._report_missing()

    def missing(self) -> List[str]:
        """Return the nodes that do not answer."""
        with self._changed:
            return [name for name, known in self._known.items() if known.process is None]

    def accept(self) -> None:
        """Accept the present processes as those with which the survey continues."""
        with self._changed:
            for known in self._known.values():
                known.accepted = known.process

    def lost(self) -> Optional[Message]:
        """Return which nodes stopped answering or restarted since `accept`; None if no node."""
        with self._changed:
            known = list(self._known.values())
            silent = [one for one in known if one.process is None]
            other = [one for one in known if one.process not in (None, one.accepted)]
            return _joined(
                [Message("{node} stopped answering", **one.named) for one in silent]
                + [Message("{node} restarted", **one.named) for one in other]
            )

    def check(self) -> None:
        """Return if every node answers and none was restarted since `accept`.

        Raises:
            NodeLostError: Names the other nodes.
        """
        lost = self.lost()
        if lost is not None:
            raise NodeLostError(lost)

    def _report_missing(self) -> None:
        starting = self._clock.now_s() < self._starting_until_s
        missing = _joined(
            [
                Message("{node} does not answer", **one.named)
                for one in self._known.values()
                if one.process is None and (one.seen or not starting)
            ]
        )
        if missing != self._reported:
            self._reported = missing
            self._on_change(missing)

    def _watch(self) -> None:
        while True:
            with self._turn:
                begun = self._next_poll()
            if begun is None:
                return
            name, poll, probe = begun
            process, late = None, False
            try:
                process = probe()
            except NodeGoneError:
                pass  # the end of its process is certain
            except NodeSilentError:
                late = True
            with self._changed:
                known = self._known[name]
                known.free.append(probe)
                known.asking -= 1
                self._due.notify()
                if late:
                    self.note_late(name)
                else:
                    self._note_result(name, poll, process)

    def _next_poll(self) -> Optional[Tuple[str, int, Callable[[], int]]]:
        """Wait until a node is due; return its name, the number of the poll, and how to ask.

        None if the watch ended.
        """
        with self._changed:
            while not self._ended:
                now_s = self._clock.now_s()
                spare = sum(one.asking for one in self._known.values()) < WATCHERS - 1
                free = {
                    name: one
                    for name, one in self._known.items()
                    if one.free and (spare or not one.asking)
                }
                name = min(free, key=lambda name: free[name].due_s, default="")
                wait_s = free[name].due_s - now_s if name else None
                if wait_s is not None and wait_s <= 0.0:
                    known = free[name]
                    known.due_s = now_s + self._period_s
                    known.polls += 1
                    known.asking += 1
                    return name, known.polls, known.free.pop(0)
                self._due.wait(wait_s)
        return None

    def _note_result(self, name: str, poll: int, process: Optional[int]) -> None:
        known = self._known[name]
        # An answer that was overtaken by that to a later poll is about the past.
        if poll > known.result:
            known.result = poll
            if process is None:
                self.note_silent(name)
            else:
                self.note_alive(name, process)
        self._changed.notify_all()


def _joined(messages: List[Message]) -> Optional[Message]:
    silent = [one.with_fault(PART_SILENT) for one in messages]
    if len(silent) > 1:
        return in_a_row(silent)
    return silent[0] if silent else None
