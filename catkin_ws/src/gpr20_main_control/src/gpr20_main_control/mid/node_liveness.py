"""Which nodes of the robot are running."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import partial
from typing import Callable, Dict, List, Mapping, Optional

from gpr20_common.errors import NodeSilentError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import NodeLostError

# Nodes that are launched together are all running after this time [s].
START_LIMIT_S = 15.0
# The death of a node is noticed after one period; a node that hangs, after the answer's limit too.
PERIOD_S = 0.4
ANSWER_LIMIT_S = 1.2
REFRESH_LIMIT_S = 2.0 * ANSWER_LIMIT_S


@dataclass(frozen=True)
class WatchedNode:
    """A node that a survey needs.

    Attributes:
        plain_name: What operators call it.
        probe: Returns the number of the node's process, or raises NodeSilentError.
    """

    plain_name: Message
    probe: Callable[[], int]


class NodeLiveness:
    """Polls the nodes and stores the last answer of each.

    Each node is polled in a thread of its own, so that one that hangs delays no other. Every
    method may be called from any thread.
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
            clock: Measures the time that nodes have to start.
            on_change: Called with a message about the nodes that do not answer, or with None
                when all of them answer.
            period_s: Time between two polls of a node [s].
        """
        self._nodes = dict(nodes)
        self._clock = clock
        self._on_change = on_change
        self._period_s = period_s
        self._changed = threading.Condition()
        self._processes: Dict[str, Optional[int]] = dict.fromkeys(nodes)
        self._accepted: Dict[str, Optional[int]] = dict(self._processes)
        self._seen: Dict[str, bool] = dict.fromkeys(nodes, False)
        self._reported: Optional[Message] = None
        self._starting_until_s = clock.now_s() + START_LIMIT_S
        self._asked: Dict[str, int] = dict.fromkeys(nodes, 0)
        self._answered: Dict[str, int] = dict.fromkeys(nodes, 0)
        self._refreshes = 0
        self._ended = False

    def start(self) -> None:
        """Begin to poll."""
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
            self._processes[name] = self._accepted[name] = None
            self._seen[name] = False
            self._asked[name] = self._answered[name] = 0
        self._start_watch(name)

    def _start_watch(self, name: str) -> None:
        threading.Thread(
            target=self._watch, args=(name,), name=f"watch {name}", daemon=True
        ).start()

    def stop(self) -> None:
        """Stop polling."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def refresh(self) -> None:
        """Poll every node now; return when all are polled, at the latest after REFRESH_LIMIT_S."""
        with self._changed:
            wanted = {name: asked + 1 for name, asked in self._asked.items()}
            self._refreshes += 1
            self._changed.notify_all()
            self._changed.wait_for(
                lambda: all(self._answered[name] >= wanted[name] for name in wanted),
                REFRESH_LIMIT_S,
            )

    def note_alive(self, name: str, process: int) -> None:
        """Note that a node has answered, and the number of its process."""
        with self._changed:
            self._processes[name] = process
            self._seen[name] = True
            self._report_missing()

    def note_silent(self, name: str) -> None:
        """Note that a node did not answer."""
        with self._changed:
            self._processes[name] = None
            self._report_missing()

    def missing(self) -> List[str]:
        """Return the nodes that do not answer."""
        with self._changed:
            return [name for name, process in self._processes.items() if process is None]

    def accept(self) -> None:
        """Accept the present processes as those with which the survey continues."""
        with self._changed:
            self._accepted = dict(self._processes)

    def lost(self) -> Optional[Message]:
        """Return which nodes stopped answering or restarted since `accept`; None if no node."""
        with self._changed:
            missing = self.missing()
            restarted = [
                name
                for name, process in self._processes.items()
                if process is not None and process != self._accepted[name]
            ]
        return _joined(
            [
                Message("{node} stopped answering", node=self._plain_name(name), details=name)
                for name in missing
            ]
            + [
                Message("{node} restarted", node=self._plain_name(name), details=name)
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
                Message("{node} does not answer", node=self._plain_name(name), details=name)
                for name in self.missing()
                if self._seen[name] or not starting
            ]
        )
        if missing != self._reported:
            self._reported = missing
            self._on_change(missing)

    def _watch(self, name: str) -> None:
        while True:
            with self._changed:
                if self._ended:
                    return
                self._asked[name] += 1
                refreshes = self._refreshes
            try:
                self.note_alive(name, self._nodes[name].probe())
            except NodeSilentError:
                self.note_silent(name)
            with self._changed:
                self._answered[name] = self._asked[name]
                self._changed.notify_all()
                self._changed.wait_for(partial(self._must_look, refreshes), self._period_s)

    def _must_look(self, refreshes: int) -> bool:
        """Return whether a refresh was requested since that many, or the watch ended."""
        return self._ended or self._refreshes != refreshes


def _joined(messages: List[Message]) -> Optional[Message]:
    if len(messages) > 1:
        return in_a_row(messages)
    return messages[0] if messages else None
