"""Who sends a message, and whether that node publishes the same pictures itself."""

from __future__ import annotations

import threading
from typing import Any, Dict

import rosgraph
import rospy

from gpr20_common.high.connection_header import connection_header


class Senders:
    """Recognizes the players of recordings that hold tf and joint_states already.

    What they publish must not be published a second time.
    """

    def __init__(self, topic: str) -> None:
        """Recognize nodes that publish a topic, which this node publishes too."""
        self._topic = rospy.resolve_name(topic)
        self._lock = threading.Lock()  # guards the one below
        self._known: Dict[str, bool] = {}

    def publishes_pictures(self, message: Any) -> bool:
        """Return whether the sender of a message publishes the topic itself."""
        sender = connection_header(message)["callerid"]
        with self._lock:
            if sender not in self._known:
                self._known[sender] = sender in self._publishers()
            return self._known[sender]

    def forget(self) -> None:
        """Forget what is known: another recording may be played under the same name."""
        with self._lock:
            self._known.clear()

    def _publishers(self) -> Any:
        try:
            published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
        except (OSError, rosgraph.MasterException) as error:
            rospy.logwarn("the ROS master does not answer: %s", error)
            return ()
        return dict(published).get(self._topic, ())
