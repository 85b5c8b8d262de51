"""The goals of an axis: taken in their order, and given up when their sender is gone."""

from __future__ import annotations

import socket
import time
from typing import Any, Callable, Dict, Iterator, Tuple

import actionlib
import rospy

from gpr20_axis_driver.low.tcp_keepalive import keep_alive, silence_s

# So long may a client's machine give no sign of life: three probes, one second each.
SILENCE_LIMIT_S = 3.5


class GoalServer(actionlib.SimpleActionServer):
    """Takes goals whatever the time of day is, and knows whether their senders still live.

    actionlib refuses a goal whose time stamp lies before that of the last one. A stamp is the
    time of day at the client: after its clock was set back by an hour, every goal of the next
    hour would be refused.

    When a client's process dies, its connection is closed by the system at once, long before the
    master or anything else notices. When its machine dies or its cable is pulled, nothing closes
    the connection, but no sign of life comes through it.
    """

    def __init__(self, name: str, action: Any, execute: Callable[[Any], None]) -> None:
        """Offer the action; `start` begins to take goals.

        Args:
            name: Relative name of the action.
            action: Generated class of the action.
            execute: Carries out one goal.
        """
        super().__init__(name, action, execute_cb=execute, auto_start=False)

    def internal_goal_callback(self, goal: actionlib.ServerGoalHandle) -> None:
        """Take a new goal, whatever its stamp says; it replaces the one before."""
        goal.get_goal_id().stamp = rospy.Time()
        super().internal_goal_callback(goal)

    def watch_sender(self) -> Callable[[], bool]:
        """Return a function that says whether the sender of the current goal has gone.

        actionlib begins a goal's id with the name of the client's node. A goal that names no node
        connected now is watched by any connection at all.
        """
        goal_id = self.current_goal.get_goal_id().id
        senders = {name for name, _ in self._connections() if goal_id.startswith(f"{name}-")}
        return self._watch(lambda name: name in senders or not senders)

    def watch_node(self, name: str) -> Callable[[], bool]:
        """Return a function that says whether a node has gone; never, if it is no client."""
        if any(name == connected for connected, _ in self._connections()):
            return self._watch(lambda connected: connected == name)
        return lambda: False

    def _watch(self, is_watched: Callable[[str], bool]) -> Callable[[], bool]:
        signs = _SignsOfLife()

        def gone() -> bool:
            # A list, because every connection is to be probed from the beginning.
            watched = [one for name, one in self._connections() if is_watched(name)]
            return not any([signs.lives(one) for one in watched])

        return gone

    def _connections(self) -> Iterator[Tuple[str, socket.socket]]:
        # rospy counts connections in public but names their nodes only here. One that waits to
        # be connected again has no socket; an action's server that was shut down, no topic.
        topic = self.action_server.goal_sub.impl
        for one in topic.connections if topic is not None else ():
            connection = one.socket
            if connection is not None:
                yield one.callerid_pub, connection


class _SignsOfLife:
    """Tells from which connections something was heard lately."""

    def __init__(self) -> None:
        self._probed_since_s: Dict[socket.socket, float] = {}

    def lives(self, connection: socket.socket) -> bool:
        """Return whether the other end's machine is there, as far as can be known by now."""
        now_s = time.monotonic()
        try:
            if connection not in self._probed_since_s:
                keep_alive(connection)
                self._probed_since_s[connection] = now_s
            # Before it was probed, silence meant nothing.
            probed_s = now_s - self._probed_since_s[connection]
            return min(probed_s, silence_s(connection)) <= SILENCE_LIMIT_S
        except OSError:
            # It was closed since it was listed.
            return False
