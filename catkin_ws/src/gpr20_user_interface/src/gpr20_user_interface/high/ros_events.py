"""Events from topics and services, until the client is closed."""

from __future__ import annotations

import threading
from typing import Any, Callable, List

import rospy

from gpr20_common.high.connection_header import connection_header
from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.robot.message_source import Received


class RosEvents:
    """Base of the clients: subscriptions, and a listener that may be gone after `close`.

    Args:
        listener: Called with each event, from threads of ROS and of the client.
    """

    def __init__(self, listener: Callable[[Any], None]) -> None:
        self._listener = listener
        self._emitting = threading.Lock()
        self._closed = False
        self._subscribers: List[rospy.Subscriber] = []

    def close(self) -> None:
        """Call the listener no more, even if messages are in flight."""
        with self._emitting:
            self._closed = True
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers.clear()

    def _subscribe(
        self, name: str, message_class: Any, convert: Callable[[Any], Any], queue_size: Any
    ) -> None:
        """Emit an event for each message of a topic; `queue_size` None: any number may wait."""
        self._subscribe_raw(
            name,
            message_class,
            lambda message: self._emit_received(message, convert(message)),
            queue_size,
        )

    def _subscribe_raw(
        self, name: str, message_class: Any, received: Callable[[Any], None], queue_size: Any
    ) -> None:
        """Call a function for each message of a topic; it may `_emit` any number of events."""
        self._subscribers.append(
            rospy.Subscriber(name, message_class, received, queue_size=queue_size)
        )

    def _emit_received(self, message: Any, event: Any) -> None:
        """Emit an event with the node that sent it."""
        self._emit(Received(connection_header(message)["callerid"], event))

    def _emit(self, event: Any) -> None:
        with self._emitting:
            if not self._closed:
                self._listener(event)


def in_background(work: Callable[[], None]) -> None:
    """Work in a daemon thread: if it never ends, the process still can."""
    threading.Thread(target=work, daemon=True).start()


def no_answer(error: Exception) -> Message:
    """Return what people read when the main control does not answer a request."""
    return Message(
        "the main control does not answer; check that it is running", details=error
    ).with_fault(faults.PART_SILENT)
