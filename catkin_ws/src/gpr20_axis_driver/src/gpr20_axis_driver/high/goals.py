"""The clients of an axis: their goals in their order, and whether they are still there."""

from __future__ import annotations

import contextlib
import functools
import socket
import struct
from typing import Any, Callable, Dict, List

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus

from gpr20_axis_driver.faults import AxisException
from gpr20_common.faults import IN_USE
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.raw_message import connection_header
from gpr20_common.low.links import PROBE_PERIOD_S, keep_alive
from gpr20_common.message import Message

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
# The first byte of struct tcp_info of <linux/tcp.h>: its state; and when data and when an
# acknowledgement came last [ms ago].
ESTABLISHED = 1
TCP_INFO_BYTES = 104
LAST_RECEIVED = struct.Struct("=II")
LAST_RECEIVED_OFFSET = 52
CONNECTION = "gpr20_connection"


class GoalServer(actionlib.SimpleActionServer):
    """Accepts goals whatever their time stamps are.

    actionlib refuses a goal whose time stamp is earlier than that of the last one. A stamp is the
    time of day at the client: after its clock was set back by an hour, every goal of the next
    hour would be refused.

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

    @property
    def connections(self) -> List[socket.socket]:
        """That node's connections; none if it is gone."""
        # rospy's public interface counts connections; only this one names their nodes. One that
        # waits to be made again has no socket.
        topic = self.action_server.goal_sub.impl
        found = topic.connections if topic is not None else ()
        own = [one.socket for one in found if one.callerid_pub == self.sender]
        return [one for one in own if one is not None]


def _sender(goal: actionlib.ServerGoalHandle) -> str:
    return str(connection_header(goal.goal)["callerid"])


def advertise_watched(name: str, kind: Any, handler: Callable[[Any], Any]) -> rospy.Service:
    """Advertise a service as `advertise` does; `connections_of` has who requests it."""
    service = advertise(name, kind, handler)
    handle = service.handle

    def handle_watched(transport: Any, header: Dict[str, Any]) -> None:
        # rospy gives the header, and nothing else of the connection, to each request.
        header[CONNECTION] = transport.socket
        handle(transport, header)

    service.handle = handle_watched  # type: ignore[method-assign]
    return service


def connections_of(request: Any) -> List[socket.socket]:
    """Return the connection over which a request came."""
    connection: Any = connection_header(request).get(CONNECTION)
    return [] if connection is None else [connection]


def watch(connections: List[socket.socket], limit_s: float) -> Callable[[], bool]:
    """Return a function that returns whether the other end of all these connections is gone.

    The system of a process that dies closes its connections at once. When a computer dies or its
    cable is pulled, nothing closes them, but the kernel's probes remain unanswered, for `limit_s`.
    """

    def is_lost(connection: socket.socket) -> bool:
        try:
            info = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, TCP_INFO_BYTES)
            silence_ms = min(LAST_RECEIVED.unpack_from(info, LAST_RECEIVED_OFFSET))
            return info[0] != ESTABLISHED or silence_ms > 1e3 * (PROBE_PERIOD_S + limit_s)
        except OSError:
            # It was closed here, too.
            return True

    for connection in connections:
        with contextlib.suppress(OSError):
            keep_alive(connection)
    return lambda: all(map(is_lost, connections))
