"""Joining the ROS graph; topics as events for a listener, and requests without waiting."""

from __future__ import annotations

import threading
from typing import Any, Callable, List, Optional

import rosgraph
import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, PART_SILENT
from gpr20_common.high.answers import message_from
from gpr20_common.high.raw_message import connection_header
from gpr20_common.low.clock import Clock
from gpr20_common.low.links import answers
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_common.terminal_text import enable_line_buffering
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.robot.events import Senders

CONTROL_SILENT = Message("the main control does not answer; check that it is running")
STORAGE_SILENT = Message("the storage does not answer; check that it is running")
# How often a warning about unusable messages is repeated.
UNUSABLE_S = 60.0


class RequestError(Exception):
    """A node does not answer, or refuses: its message keeps its own fault, or has none."""

    def __init__(self, message: Message) -> None:
        super().__init__(str(message))
        self.message = message


def accepted(response: Any) -> Any:
    """Return the response.

    Raises:
        RequestError: It says that the request was refused, or failed.
    """
    if not response.success:
        raise RequestError(message_from(response))
    return response


def no_answer(silent: Message, error: Exception) -> Message:
    """Return what people read when a node does not answer."""
    return silent.with_details(error).with_fault(PART_SILENT)


def in_background(work: Callable[[], None]) -> None:
    """Work in a daemon thread: if it never ends, the process still can."""

    def logged() -> None:
        with faults_logged("request"):
            work()

    threading.Thread(target=logged, daemon=True).start()


class RosEvents:
    """Base of the clients: subscriptions, and a listener that may be gone after `close`.

    It is called with each event, from threads of ROS and of the client; messages of others than
    the `senders` that count are never passed on.
    """

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        self._listener, self._senders = listener, senders
        self._clock = Clock()
        self._emitting = threading.Lock()
        self._closed = self._watched = False
        self._following = threading.Lock()
        self._subscribers: List[rospy.Subscriber] = []
        # Those that exist while somebody looks: each message costs time.
        self._watching: List[rospy.Subscriber] = []

    def close(self) -> None:
        """Call the listener no more, even if messages are in flight."""
        with self._emitting:
            self._closed = True
        self.set_watched(False)
        for subscriber in self._subscribers:
            subscriber.unregister()

    def set_watched(self, watched: bool) -> None:
        """Subscribe to what people see only while they look, or no longer; without waiting."""
        if watched != self._watched:
            self._watched = watched
            # A subscription waits for the master, which may be away.
            in_background(self._follow)

    def _follow(self) -> None:
        with self._following:
            if self._watched == bool(self._watching):
                return
            for subscriber in self._watching:
                subscriber.unregister()
            self._watching = self._watched_topics() if self._watched else []

    def _watched_topics(self) -> List[rospy.Subscriber]:
        """Subscribe to what `set_watched` is about."""
        return []

    def _subscribe(self, *topic: Any) -> None:
        """Follow a topic until the client is closed; see `_subscriber`."""
        self._subscribers.append(self._subscriber(*topic))

    def _subscriber(
        self,
        name: str,
        message_class: Any,
        convert: Callable[[Any], Any],
        queue_size: Optional[int] = None,
    ) -> rospy.Subscriber:
        """Emit an event for each message of a topic, none where `convert` returns None.

        Without a `queue_size` any number of messages may wait.
        """

        def received(message: Any) -> None:
            sender = connection_header(message)["callerid"]
            if not self._senders.takes(sender):
                if not self._senders.replay:
                    rospy.logwarn_once(
                        "messages of %s are ignored: it is no node of this robot", sender
                    )
                return
            try:
                event = convert(message)
            except (ValueError, Gpr20Error) as error:
                # Of a damaged recording, or of another version.
                rospy.logwarn_throttle(UNUSABLE_S, "unusable message of %s: %s", name, error)
                return
            if event is not None:
                self._emit(event)

        return rospy.Subscriber(name, message_class, received, queue_size=queue_size)

    def _emit(self, event: Any) -> None:
        with self._emitting:
            if not self._closed:
                self._listener(event)


POLL_S = 0.2
# A master that works answers sooner [s].
MASTER_LIMIT_S = 2.0


def join_graph(name: str, wait_s: float, is_cancelled: Callable[[], bool], clock: Clock) -> None:
    """Make this process a ROS node that leaves Ctrl-C to its own handlers.

    `rospy.init_node` alone would wait for a master without a limit.

    Args:
        name: Base name of the node; a number makes it one of its own.
        wait_s: How long to wait for the master [s].
        is_cancelled: Checked while waiting; True ends it.
        clock: Measures the waiting.

    Raises:
        MasterUnavailableError: No master answered in time, or it was cancelled.
    """
    enable_line_buffering()
    master, begin_s, never = rosgraph.get_master_uri(), clock.now_s(), threading.Event()
    while not answers(master, name, MASTER_LIMIT_S):
        waited_s = clock.now_s() - begin_s
        if is_cancelled():
            raise MasterUnavailableError(
                Message("stopped before contact with the robot; nothing was started"),
                fault=ASKED_FOR,
            )
        if waited_s > wait_s:
            raise MasterUnavailableError(
                Message(
                    "no ROS master answers at {address} within {waited_s:.0f} s; start `roslaunch "
                    "gpr20 survey.launch`, or correct ROS_MASTER_URI",
                    address=master,
                    waited_s=waited_s,
                )
            )
        clock.wait_s(never, POLL_S)
    rospy.init_node(name, anonymous=True, disable_rostime=True, disable_signals=True)
