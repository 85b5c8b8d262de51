"""Follow a replay in the terminal client: nothing can be asked of it."""

from __future__ import annotations

import queue
import threading
from dataclasses import replace
from typing import Callable, List, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.robot.events import ControlState, Progress, Request, StopRequested
from gpr20_operator.robot.message_source import MessageSources, Received, SourceGone
from gpr20_operator.robot.replay import ReplayMark, ReplayPhase
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface.terminal.follower import ExitStatus, Outcome

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


REFUSAL = Message(
    "A replay of a recorded survey is running here, and no robot. Only --attach can follow it. To "
    "use a robot, end the replay and start the robot."
).with_fault(faults.REPLAY_RUNS)


class ReplayFollower:
    """Takes events and gives in the end an outcome.

    Attributes:
        outcome: How it ended; None while it has not.
        survey_id: The recorded survey; empty while it is not known.
    """

    def __init__(self) -> None:
        self.outcome: Optional[Outcome] = None
        self.survey_id = ""
        self._state: Optional[ControlState] = None

    def concerns(self, event: object) -> bool:
        """Return whether an event is to be shown."""
        return not isinstance(event, StopRequested)

    def handle(self, event: object) -> List[Request]:
        """Take an event; there is never a request to send."""
        if isinstance(event, ControlState):
            self._state = event
            self.survey_id = event.survey_id or self.survey_id
        elif isinstance(event, Progress):
            self.survey_id = event.survey_id or self.survey_id
        elif isinstance(event, StopRequested):
            message = Message("The replay is no longer followed.")
            self.outcome = Outcome(ExitStatus.STOPPED, message)
        elif isinstance(event, SourceGone) or _has_ended(event):
            self.outcome = Outcome(ExitStatus.REPLAY, self._end())
        return []

    def tick(self) -> List[Request]:
        """Nothing is due: a replay may pause for any time."""
        return []

    def _end(self) -> Message:
        if self._state is None or self._state.code not in ENDED:
            return Message("The recording does not contain the survey's end.")
        return Message(
            "The recorded survey ended {state}: {message}",
            state=self._state.code.label,
            message=self._state.message,
        )


def _has_ended(event: object) -> bool:
    return isinstance(event, ReplayMark) and event.phase is ReplayPhase.ENDED
