"""Which nodes of the robot are running."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Optional

from gpr20_common.errors import NodeSilentError
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

# Returns the number of a node's process, or raises NodeSilentError after SILENCE_LIMIT_S.
Probe = Callable[[], int]


@dataclass
class _Known:
    """A node: its names for a message, its process (None: silent) and the one that is accepted."""

    named: Dict[str, object]
    process: Optional[int] = None
    accepted: Optional[int] = None
    seen: bool = False
    # When it was asked for the last result [s].
    asked_s: float = -math.inf
    # Set when the next question must not wait for its turn.
    ask_now: threading.Event = field(default_factory=threading.Event)


class NodeLiveness:
    """Asks each node again and again, in a thread for each: one that hangs delays no other.

    A node is missing if its process has ended, or if it has not answered for SILENCE_LIMIT_S. Every
    method may be called from any thread.
    """

    def __init__(
        self,
        clock: Clock,
        on_change: Callable[[Optional[Message]], None],
        period_s: float = PERIOD_S,
    ) -> None:
        """Begin without a node.

        `on_change` is called with a message about the nodes that do not answer, or with None when
        all of them answer; each is asked again after `period_s`.
        """
        self._clock, self._on_change, self._period_s = clock, on_change, period_s
        self._changed = threading.Condition(threading.RLock())
        self._known: Dict[str, _Known] = {}
        self._reported: Optional[Message] = None
        self._starting_until_s = clock.now_s() + START_LIMIT_S
        self._ended = False

    def watch(self, name: str, plain_name: Message, probe: Optional[Probe]) -> None:
        """Watch one more node, which counts as silent at first; one that is watched stays.

        Without a `probe` it is not asked: who knows calls `note`.
        """
        with self._changed:
            if name in self._known:
                return
            self._known[name] = _Known({"node": plain_name, "details": name})
        if probe is not None:
            asked = (name, probe)
            threading.Thread(target=self._ask, args=asked, name="node watch", daemon=True).start()

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            for known in self._known.values():
                known.ask_now.set()

    def refresh(self) -> None:
        """Ask every node now; return when all have answered or are known to be missing."""
        with self._changed:
            begun_s, nodes = time.monotonic(), tuple(self._known.values())
            for known in nodes:
                known.ask_now.set()
            self._changed.wait_for(
                lambda: all(one.asked_s >= begun_s for one in nodes), REFRESH_LIMIT_S
            )

    def note(self, name: str, process: Optional[int]) -> None:
        """Note the number of the process that has answered as a node; None: it is silent."""
        with self._changed:
            known = self._known[name]
            known.process = process
            known.seen |= process is not None
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
        """Raise a NodeLostError unless every node answers and none restarted since `accept`."""
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

    def _ask(self, name: str, probe: Probe) -> None:
        known = self._known[name]
        while not self._ended:
            known.ask_now.clear()
            asked_s, process = time.monotonic(), None
            # A node that does not answer is missing.
            with contextlib.suppress(NodeSilentError):
                process = probe()
            with self._changed:
                known.asked_s = asked_s
                self.note(name, process)
                self._changed.notify_all()
            known.ask_now.wait(self._period_s)


def _joined(messages: List[Message]) -> Optional[Message]:
    if not messages:
        return None
    return in_a_row(one.with_fault(PART_SILENT) for one in messages)
