"""What ROBOT shows while it is in front: endstops, clocks, and what is done for maintenance."""

from __future__ import annotations

import os
import socket
from functools import partial
from typing import Any, Callable, List, Mapping

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool

from gpr20_common.high.answers import message_from
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import ThisMachine
from gpr20_doctor.mid.node_health import NodeHealth
from gpr20_msgs.msg import ServiceStatus
from gpr20_operator.high.ros_events import RosEvents, WhileWatched, in_background
from gpr20_operator.jobs.job import Delivery, Ticket
from gpr20_operator.robot.events import ClockOffset, EndstopState, ServiceActivity
from gpr20_operator.robot.senders import Senders
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription

ENDSTOP_AXES = (AxisId.X, AxisId.Y)


class RobotWatchClient(RosEvents):
    """Follows the robot, and looks at this computer, without waiting."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._watched = WhileWatched(self._subscriptions)

    def listen(self) -> None:
        """Subscribe to what is done for maintenance."""
        self._subscribe("service_status", ServiceStatus, _activity, None)

    def close(self) -> None:
        """Call the listener no more."""
        self.set_watched(False)
        super().close()

    def set_watched(self, watched: bool) -> None:
        """Follow endstops and clocks, or no longer: each message costs time."""
        self._watched.set_watched(watched)

    def examine(
        self,
        ticket: Ticket[MachineFacts],
        nodes: Mapping[str, NodeDescription],
        surveying: bool,
        thorough: bool,
    ) -> None:
        """Look at this computer in the background."""

        def look() -> None:
            machine = ThisMachine(socket.gethostname(), os.environ)
            facts = probe_machine(machine.request(nodes, surveying, thorough=thorough))
            self._emit(Delivery(partial(ticket.done, facts)))

        in_background(look)

    def _subscriptions(self) -> List[rospy.Subscriber]:
        def endstop(axis: AxisId) -> rospy.Subscriber:
            topic = f"{axis.value}_axis/endstop"
            return self._subscriber(topic, Bool, lambda one: EndstopState(axis, one.data), 10)

        return [*map(endstop, ENDSTOP_AXES), self._diagnostics_subscriber(_offset)]


def _activity(message: ServiceStatus) -> ServiceActivity:
    return ServiceActivity(message_from(message) if message.busy else None)


def _offset(health: NodeHealth, message: DiagnosticArray) -> ClockOffset:
    return ClockOffset(health.name, (rospy.Time.now() - message.header.stamp).to_sec())
