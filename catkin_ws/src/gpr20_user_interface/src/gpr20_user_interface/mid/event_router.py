"""The events of a robot and those of a replay, apart, for the terminal client."""

from __future__ import annotations

import queue
import threading
from dataclasses import replace
from typing import Callable

from gpr20_common.low.clock import Clock
from gpr20_user_interface.mid.events import ControlState, StopRequested
from gpr20_user_interface.mid.message_source import MessageSources, Received, SourceGone
from gpr20_user_interface.mid.replay import ReplayMark

POLL_S = 0.1
# A robot beside the replay reports itself within this time [s].
ROBOT_LIMIT_S = 2.0


class EventRouter:
    """Takes events from any thread and puts each into one of two queues.

    Args:
        sources: Tells robots from replays.

    Attributes:
        robot: What the robot sends, and what does not come from the graph.
        replay: What a replay sends.
    """

    def __init__(self, sources: MessageSources) -> None:
        self._sources = sources
        # Unlike that of queue.Queue its put() may be interrupted by a signal that puts, too.
        self.robot: queue.SimpleQueue = queue.SimpleQueue()
        self.replay: queue.SimpleQueue = queue.SimpleQueue()
        self._robot_seen = threading.Event()
        self._replay_seen = threading.Event()
        self._lock = threading.Lock()

    def stop(self, request: StopRequested) -> None:
        """Take the operator's wish to stop; may be called by a signal handler."""
        self.robot.put(request)
        self.replay.put(request)

    def take(self, event: object) -> None:
        """Take an event."""
        if isinstance(event, SourceGone):
            if self._sources.is_replay(event.source):
                self.replay.put(event)
        elif isinstance(event, Received):
            with self._lock:
                self._take_received(event)
        else:
            self.robot.put(event)

    def wait_for_replay(
        self, wait_s: float, is_cancelled: Callable[[], bool], clock: Clock
    ) -> bool:
        """Wait until there is a robot or a replay; return whether there is a replay alone.

        Args:
            wait_s: Longest wait [s].
            is_cancelled: Checked while waiting; True ends it.
            clock: Measures the waiting.
        """
        deadline_s = clock.now_s() + wait_s
        alone_s = 0.0
        while not self._robot_seen.is_set() and clock.now_s() < deadline_s:
            if is_cancelled():
                return False
            if self._replay_seen.is_set():
                alone_s = alone_s or clock.now_s()
                if clock.now_s() - alone_s >= ROBOT_LIMIT_S:
                    return True
            clock.wait_s(self._robot_seen, POLL_S)
        return False

    def _take_received(self, received: Received) -> None:
        source, event = received.source, received.event
        if isinstance(event, ReplayMark):
            self._sources.note_mark(source)
        if self._sources.is_replay(source):
            self._replay_seen.set()
            self.replay.put(
                replace(event, replay=True) if isinstance(event, ControlState) else event
            )
        elif not isinstance(event, ReplayMark):
            self._robot_seen.set()
            self.robot.put(event)
