"""The topics between the window and the web page: `remote_control` and `web_status`."""

from __future__ import annotations

from typing import Any, Callable, Optional

import rospy

from gpr20_common.high.periodic import Periodic
from gpr20_doctor.mid.node_health import WEB
from gpr20_msgs.msg import RemoteControl, WebStatus
from gpr20_operator.high import conversions
from gpr20_operator.high.ros_events import RosEvents
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.remote_control import (
    RemoteArmed,
    RemotePlan,
    WebPageGone,
    WebStatusReported,
)
from gpr20_survey.plan.annotation import from_fields

WINDOW = "user_interface"
LINK_PERIOD_S = 1.0


class RemoteControlClient(RosEvents):
    """The web page's side: what the window of its robot allows, and nobody else.

    Args:
        listener: Gets the events.
        namespace: Of the robot, with slashes at both ends or alone.
    """

    def __init__(self, listener: Callable[[Any], None], namespace: str) -> None:
        super().__init__(listener, Senders(namespace, nodes=(WINDOW,)))

    def listen(self) -> None:
        self._subscribe("remote_control", RemoteControl, remote_armed, None)


class WebPageClient(RosEvents):
    """The window's side: what the web page says of itself, and what the window allows it.

    Args:
        listener: Gets the events.
        senders: Of the window; where they are a replay's there is nobody to allow anything.
    """

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, Senders(senders.namespace, senders.replay, nodes=(WEB,)))
        self._remote: Optional[rospy.Publisher] = None
        self._link: Optional[Periodic] = None
        self._linked = False

    def listen(self) -> None:
        if self._senders.replay:
            return
        self._remote = rospy.Publisher("remote_control", RemoteControl, queue_size=10, latch=True)
        self._subscribe("web_status", WebStatus, web_status, None)
        (topic,) = self._subscribers
        self._link = Periodic(LINK_PERIOD_S, lambda: self._check_link(topic))

    def close(self) -> None:
        """Call the listener no more."""
        if self._link is not None:
            self._link.stop()
        super().close()

    def send(self, event: RemoteArmed) -> None:
        """Publish what is allowed; not when this node ends, which allows nothing any more."""
        if self._remote is not None and not rospy.is_shutdown():
            self._remote.publish(remote_message(event))

    def _check_link(self, topic: rospy.Subscriber) -> None:
        linked = topic.get_num_connections() > 0
        if self._linked and not linked:
            self._emit(WebPageGone())
        self._linked = linked


def remote_message(event: RemoteArmed) -> RemoteControl:
    """Return the message of an event."""
    message = RemoteControl(
        armed=event.armed,
        remaining=rospy.Duration.from_sec(event.remaining_s),
        has_plan=event.plan is not None,
    )
    if event.plan is not None:
        message.parameters = conversions.parameters_message(event.plan.parameters)
        message.annotation = conversions.annotation_message(event.plan.annotation)
        message.refines, message.permittivity = event.plan.refines, event.plan.permittivity
    return message


def remote_armed(message: RemoteControl) -> RemoteArmed:
    """Convert `remote_control`."""
    plan = None
    if message.has_plan:
        plan = RemotePlan(
            conversions.parameters(message.parameters),
            from_fields(message.annotation),
            message.refines,
            message.permittivity,
        )
    return RemoteArmed(message.armed, message.remaining.to_sec(), plan)


def web_status(message: WebStatus) -> WebStatusReported:
    """Convert `web_status`."""
    return WebStatusReported(
        *(message.address, message.port, message.fingerprint, message.watchers),
        message.controller,
    )
