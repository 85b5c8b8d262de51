"""Which nodes of the robot are running."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, List, Mapping, Optional, Sequence

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
        process: The number of its process; None if the node does not answer.
        accepted: The process with which the survey continues.
        seen: Whether it ever answered.
        answered_s: When it answered last [s].
        polls: How many polls have begun.
        result: The last of these polls that had a result; earlier ones say nothing new.
        due_s: When the next poll begins [s].
        tickets: How many times threads have asked for a poll; each in its turn.
        served: How many of them got one.
        due: Notified when `due_s` has changed.
        turn: Notified when `served` has changed.
    """

    due: threading.Condition
    turn: threading.Condition

    process: Optional[int] = None
    accepted: Optional[int] = None
    seen: bool = False
    answered_s: float = 0.0
    polls: int = 0
    result: int = 0
    due_s: float = 0.0
    tickets: int = 0
    served: int = 0


class NodeLiveness:
    """Polls the nodes and stores the last answer of each.

    Each connection to a node is polled in a thread of its own, so that one that hangs delays no
    other. A node is missing if its process has ended, or if it has not answered on any connection
    for SILENCE_LIMIT_S. Every method may be called from any thread.
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
        self._nodes = dict(nodes)
        self._clock = clock
        self._on_change = on_change
        self._period_s = period_s
        # Conditions share a lock: an answer wakes only the threads that wait for it.
        lock = threading.RLock()
        self._changed = threading.Condition(lock)
        self._new_known = lambda: _Known(threading.Condition(lock), threading.Condition(lock))
        self._known = {name: self._new_known() for name in nodes}
        self._reported: Optional[Message] = None
        self._starting_until_s = clock.now_s() + START_LIMIT_S
        self._ended = False

    def start(self) -> None:
        for name in self._nodes:
            self._start_watch(name)

    def watch(self, name: str, node: WatchedNode) -> None:
        """Poll one more node, which is noted as silent at first; a node that is polled stays.

        The processes that a survey accepted before do not include it: nothing is lost.
        """
        with self._changed:
            if name in self._nodes:
                return
            self._nodes[name] = node
            self._known[name] = self._new_known()
        self._start_watch(name)

    def _start_watch(self, name: str) -> None:
        for probe in self._nodes[name].probes:
            threading.Thread(
                target=self._watch, args=(name, probe), name=f"watch {name}", daemon=True
            ).start()

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            for known in self._known.values():
                known.due.notify_all()
                known.turn.notify_all()

    def refresh(self) -> None:
        """Poll every node now; return when all have answered or are known to be missing."""
        with self._changed:
            before = {name: known.polls for name, known in self._known.items()}
            for known in self._known.values():
                known.due_s = self._clock.now_s()
                known.due.notify_all()
            self._changed.wait_for(
                lambda: all(self._known[name].result > polls for name, polls in before.items()),
                REFRESH_LIMIT_S,
            )
            for name in before:
                self._note_silence(name)

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
            self._note_silence(name)

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
            missing = self.missing()
            restarted = [
                name
                for name, known in self._known.items()
                if known.process is not None and known.process != known.accepted
            ]
        return _joined(
            [
                Message(
                    "{node} stopped answering", node=self._plain_name(name), details=name
                ).with_fault(PART_SILENT)
                for name in missing
            ]
            + [
                Message("{node} restarted", node=self._plain_name(name), details=name).with_fault(
                    PART_SILENT
                )
                for name in restarted
            ]
        )

    def check(self) -> None:
        """Return if every node answers and none was restarted since `accept`.

        Raises:
            NodeLostError: Names the other nodes.
        """
        lost = self.lost()
        if lost is not None:
            raise NodeLostError(lost)

    def _plain_name(self, name: str) -> Message:
        return self._nodes[name].plain_name

    def _report_missing(self) -> None:
        starting = self._clock.now_s() < self._starting_until_s
        missing = _joined(
            [
                Message(
                    "{node} does not answer", node=self._plain_name(name), details=name
                ).with_fault(PART_SILENT)
                for name in self.missing()
                if self._known[name].seen or not starting
            ]
        )
        if missing != self._reported:
            self._reported = missing
            self._on_change(missing)

    def _note_silence(self, name: str) -> None:
        known = self._known[name]
        if self._clock.now_s() - known.answered_s > SILENCE_LIMIT_S:
            known.process = None
        self._report_missing()

    def _watch(self, name: str, probe: Callable[[], int]) -> None:
        while True:
            poll = self._wait_for_turn(name)
            if poll is None:
                return
            process: Optional[int] = None
            try:
                process = probe()
            except NodeGoneError:
                # The end of its process is certain.
                pass
            except NodeSilentError:
                self.note_late(name)
                continue
            self._note_result(name, poll, process)

    def _wait_for_turn(self, name: str) -> Optional[int]:
        """Wait until the node is due; return the number of the poll, None if the watch ended."""
        with self._changed:
            known = self._known[name]
            # One thread waits for the time; the others are spare while its poll has no answer.
            ticket, known.tickets = known.tickets, known.tickets + 1
            while known.served != ticket and not self._ended:
                known.turn.wait()
            try:
                return self._wait_until_due(known)
            finally:
                known.served += 1
                # They wait in the order of their tickets.
                known.turn.notify()

    def _wait_until_due(self, known: _Known) -> Optional[int]:
        while not self._ended:
            wait_s = known.due_s - self._clock.now_s()
            if wait_s <= 0.0:
                known.due_s += self._period_s - wait_s
                known.polls += 1
                return known.polls
            known.due.wait(wait_s)
        return None

    def _note_result(self, name: str, poll: int, process: Optional[int]) -> None:
        with self._changed:
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
    if len(messages) > 1:
        return in_a_row(messages)
    return messages[0] if messages else None
