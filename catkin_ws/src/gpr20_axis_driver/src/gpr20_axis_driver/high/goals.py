"""The goals of an axis: accepted in their order, and ended when their sender is gone."""

from __future__ import annotations

import functools
import socket
import time
from typing import Any, Callable, Dict, Iterator, Tuple

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus

from gpr20_axis_driver.axis_exceptions import AxisException
from gpr20_common.faults import IN_USE
from gpr20_common.high.answers import message_fields
from gpr20_common.high.raw_message import connection_header
from gpr20_common.low.links import keep_alive, silence_s
from gpr20_common.message import Message

# How long a client's computer may leave probes unanswered: three probes, one second each.
SILENCE_LIMIT_S = 3.5
# actionlib publishes the status five times a second.
STATUS_LIMIT_S = 1.0
# How many goals that have ended are still listed in the status. A client sends its next goal when
# it has the result of the one before, so it no longer waits for these.
LISTED_GOALS = 4
NOT_BEGUN = Message(
    "a stop or another motion came before this motion began; request it again"
).with_fault(IN_USE)
ENDED = frozenset(
    (
        GoalStatus.SUCCEEDED,
        GoalStatus.ABORTED,
        GoalStatus.PREEMPTED,
        GoalStatus.REJECTED,
        GoalStatus.RECALLED,
    )
)


class GoalServer(actionlib.SimpleActionServer):
    """Accepts goals whatever their time stamps are, and detects that their sender is gone.

    actionlib refuses a goal whose time stamp is earlier than that of the last one. A stamp is the
    time of day at the client: after its clock was set back by an hour, every goal of the next
    hour would be refused.

    When a client's process dies, the system closes its connection at once, long before the
    master or anything else notices. When its computer dies or its cable is pulled, nothing closes
    the connection, but its probes remain unanswered.

    actionlib lists every goal of the last five seconds in each status, and publishes two for each
    goal: with a hundred short moves per second this would be most of the node's work.
    """

    def __init__(
        self,
        name: str,
        action: Any,
        execute: Callable[[Any], None],
        check_sender: Callable[[str], None],
    ) -> None:
        """Create the server; `start` begins to accept goals.

        Args:
            name: Relative name of the action.
            action: Generated class of the action.
            execute: Carries out one goal.
            check_sender: Takes the name of a goal's sender; raises if it may not move the axis.
        """
        super().__init__(name, action, execute_cb=execute, auto_start=False)
        # It makes the results of goals that it ends before `execute` has them.
        self._check_sender = check_sender
        server = self.action_server
        server.ActionResultType = functools.partial(
            server.ActionResultType, **message_fields(NOT_BEGUN)
        )

    def internal_goal_callback(self, goal: actionlib.ServerGoalHandle) -> None:
        """Accept a new goal, whatever its stamp; it replaces the previous one of its sender."""
        try:
            self._check_sender(_sender(goal))
        except AxisException as error:
            rospy.logwarn("goal refused: %s", error)
            result = self.action_server.ActionResultType(**message_fields(error.message))
            goal.set_rejected(result, result.message)
            return
        goal.get_goal_id().stamp = rospy.Time()
        self._forget_old_goals()
        super().internal_goal_callback(goal)

    def _forget_old_goals(self) -> None:
        # actionlib calls this with its lock held.
        listed = self.action_server.status_list
        ended = [one for one in listed if one.status.status in ENDED]
        for one in ended[:-LISTED_GOALS]:
            listed.remove(one)

    def stop_status(self) -> None:
        """Return when no status is published and none will be; actionlib does so until the end.

        Without it a status may be published to a topic that is closed while the node ends.
        """
        timer = self.action_server.status_timer
        if timer is not None:
            timer.shutdown()
            timer.join(STATUS_LIMIT_S)

    @property
    def sender(self) -> str:
        """The node that sent the current goal."""
        return _sender(self.current_goal)

    def watch_sender(self) -> Callable[[], bool]:
        """Return a function that returns whether the sender of the current goal is gone.

        actionlib begins a goal's id with the name of the client's node. If no node of this name
        is connected now, the sender counts as gone only when every client is.
        """
        goal_id = self.current_goal.get_goal_id().id
        senders = {name for name, _ in self._connections() if goal_id.startswith(f"{name}-")}
        return self._watch(lambda name: name in senders or not senders)

    def watch_node(self, name: str) -> Callable[[], bool]:
        """Return a function that returns whether a node is gone; never, if it is no client."""
        if any(name == connected for connected, _ in self._connections()):
            return self._watch(lambda connected: connected == name)
        return lambda: False

    def _watch(self, is_watched: Callable[[str], bool]) -> Callable[[], bool]:
        liveness = _ConnectionLiveness()

        def gone() -> bool:
            # A list, because every connection must be probed from the beginning.
            watched = [one for name, one in self._connections() if is_watched(name)]
            if not watched:
                # Its process has ended: the system closed the connections.
                return True
            watched += [one for name, one in self._status_connections() if is_watched(name)]
            return not any([liveness.is_alive(one) for one in watched])

        return gone

    def _connections(self) -> Iterator[Tuple[str, socket.socket]]:
        # rospy's public interface counts connections; only this one names their nodes. A connection
        # that waits to be made again has no socket; a server that was shut down has no topic.
        topic = self.action_server.goal_sub.impl
        for one in topic.connections if topic is not None else ():
            connection = one.socket
            if connection is not None:
                yield one.callerid_pub, connection

    def _status_connections(self) -> Iterator[Tuple[str, socket.socket]]:
        # Over a link that loses packets, one connection may be silent for seconds while another
        # is not. On these the client's system acknowledges five messages per second.
        topic = self.action_server.status_pub.impl
        for one in topic.connections if topic is not None else ():
            connection = one.socket
            if connection is not None:
                yield one.endpoint_id, connection


def _sender(goal: actionlib.ServerGoalHandle) -> str:
    return connection_header(goal.goal)["callerid"]


class ClientContact:
    """Whether the contact with the client of a motion was lost at any moment of the motion.

    Attributes:
        was_lost: Whether it was; the client may be back already.
    """

    def __init__(self, is_gone: Callable[[], bool]) -> None:
        self._is_gone = is_gone
        self.was_lost = False

    def is_lost(self) -> bool:
        """Check the contact now; return whether it is or was lost."""
        self.was_lost = self.was_lost or self._is_gone()
        return self.was_lost


class _ConnectionLiveness:
    """Probes connections and knows which of them answered recently."""

    def __init__(self) -> None:
        self._probed_since_s: Dict[socket.socket, float] = {}

    def is_alive(self, connection: socket.socket) -> bool:
        """Return whether the other end's computer is there, as far as is known by now."""
        now_s = time.monotonic()
        try:
            if connection not in self._probed_since_s:
                keep_alive(connection)
                self._probed_since_s[connection] = now_s
            # Silence before the first probe means nothing.
            probed_s = now_s - self._probed_since_s[connection]
            return min(probed_s, silence_s(connection)) <= SILENCE_LIMIT_S
        except OSError:
            # It was closed after it was listed.
            return False
