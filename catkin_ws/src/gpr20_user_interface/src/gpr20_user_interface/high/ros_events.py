"""Events from topics and answers, told to a listener until it wants no more."""

from __future__ import annotations

import threading
from typing import Any, Callable, List

import rospy


class RosEvents:
    """Subscriptions to topics, and a listener that may be gone once it was closed.

    Args:
        listener: Called with each event, from threads of ROS and of whoever calls `tell`.
    """

    def __init__(self, listener: Callable[[Any], None]) -> None:
        self._listener = listener
        self._telling = threading.Lock()
        self._closed = False
        self._subscribers: List[rospy.Subscriber] = []

    def subscribe(
        self, name: str, message_class: Any, convert: Callable[[Any], Any], queue_size: Any
    ) -> None:
        """Tell an event for each message of a topic.

        Args:
            name: Name of the topic.
            message_class: Its type.
            convert: Makes the event of a message.
            queue_size: How many messages may wait; None: any number.
        """
        self.subscribe_raw(
            name, message_class, lambda message: self.tell(convert(message)), queue_size
        )

    def subscribe_raw(
        self, name: str, message_class: Any, heard: Callable[[Any], None], queue_size: Any
    ) -> None:
        """Call a function for each message of a topic; it may `tell` as often as it likes."""
        self._subscribers.append(
            rospy.Subscriber(name, message_class, heard, queue_size=queue_size)
        )

    def tell(self, event: Any) -> None:
        """Tell the listener, unless it wants no more."""
        with self._telling:
            if not self._closed:
                self._listener(event)

    def close(self) -> None:
        """Tell nothing more, whatever is still on its way."""
        with self._telling:
            self._closed = True
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers.clear()


def in_background(work: Callable[[], None]) -> None:
    """Do something in a thread that, if it never ends, does not keep the process alive."""
    threading.Thread(target=work, daemon=True).start()
