"""Whether the client that sent a goal still lives."""

from __future__ import annotations

from typing import Callable, Set

import rospy


class GoalClients:
    """Watches the connections of an action's goal topic.

    When a client's process dies, its connection is closed by the system at once, long before the
    master or anything else notices.
    """

    def __init__(self, goal_subscriber: rospy.Subscriber) -> None:
        self._subscriber = goal_subscriber

    def watch(self, goal_id: str) -> Callable[[], bool]:
        """Return what tells whether the sender of a goal has gone.

        Args:
            goal_id: Its id, which actionlib begins with the name of the client's node. A goal
                that names no node connected now is watched by any connection at all.
        """
        senders = {name for name in self._connected() if goal_id.startswith(f"{name}-")}
        return self._gone(senders) if senders else lambda: not self._connected()

    def watch_node(self, name: str) -> Callable[[], bool]:
        """Return what tells whether a node has gone; never, if it is no client of the action."""
        if name in self._connected():
            return self._gone({name})
        return lambda: False

    def _gone(self, names: Set[str]) -> Callable[[], bool]:
        return lambda: names.isdisjoint(self._connected())

    def _connected(self) -> Set[str]:
        # rospy counts connections in public but names their nodes only here. One that waits to
        # be connected again has no socket.
        topic = self._subscriber.impl
        if topic is None:
            # The action's server has been shut down.
            return set()
        return {one.callerid_pub for one in topic.connections if one.socket is not None}
