"""The topics between the window and the web page: `remote_control` and `web_status`."""

from __future__ import annotations

from typing import Any, Callable, Optional

import rospy

from gpr20_common.high.answers import record_of
from gpr20_doctor.mid.node_health import WEB
from gpr20_msgs.msg import RemoteControl, WebStatus
from gpr20_operator.high.control_client import parameters, plan_fields
from gpr20_operator.high.ros_events import RosEvents
from gpr20_operator.robot.events import Senders, StartPlan
from gpr20_operator.robot.remote_control import RemoteArmed, WebStatusReported
from gpr20_survey.plan.annotation import from_fields

WINDOW = "user_interface"


class RemoteControlClient(RosEvents):
    """The web page's side: what the window of its robot allows, and nobody else.

    Args:
        listener: Gets the events.
        namespace: Of the robot, with slashes at both ends or alone.
    """

    def __init__(self, listener: Callable[[Any], None], namespace: str) -> None:
        super().__init__(listener, Senders(namespace, nodes=(WINDOW,)))

    def listen(self) -> None:
        self._subscribe("remote_control", RemoteControl, remote_armed)


class WebPageClient(RosEvents):
    """The window's side: what the web page says of itself, and what the window allows it.

    Args:
        listener: Gets the events.
        namespace: Of the robot, with slashes at both ends or alone.
    """

    def __init__(self, listener: Callable[[Any], None], namespace: str) -> None:
        super().__init__(listener, Senders(namespace, nodes=(WEB,)))
        self._remote: Optional[rospy.Publisher] = None

    def listen(self) -> None:
        self._remote = rospy.Publisher("remote_control", RemoteControl, queue_size=10, latch=True)
        self._subscribe("web_status", WebStatus, lambda one: record_of(WebStatusReported, one))

    def send(self, event: RemoteArmed) -> None:
        """Publish what is allowed; not when this node ends, which allows nothing any more."""
        if self._remote is not None and not rospy.is_shutdown():
            self._remote.publish(remote_message(event))


def remote_message(event: RemoteArmed) -> RemoteControl:
    """Return the message of an event."""
    fields = {} if event.plan is None else {"has_plan": True, **plan_fields(event.plan)}
    remaining = rospy.Duration.from_sec(event.remaining_s)
    return RemoteControl(armed=event.armed, remaining=remaining, **fields)


def remote_armed(message: RemoteControl) -> RemoteArmed:
    """Convert `remote_control`."""
    remaining_s = message.remaining.to_sec()
    if not message.has_plan:
        return RemoteArmed(message.armed, remaining_s)
    plan = StartPlan(
        parameters(message.parameters),
        from_fields(message.annotation),
        message.refines,
        message.permittivity,
    )
    return RemoteArmed(message.armed, remaining_s, plan)
