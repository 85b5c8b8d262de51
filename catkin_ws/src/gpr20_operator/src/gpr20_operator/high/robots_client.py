"""Which robots the master knows, and what each one does."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, FrozenSet

import rosgraph
import rospy

from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import connection_header
from gpr20_doctor.low.masters import robots_on_master
from gpr20_msgs.msg import ControlStatus
from gpr20_operator.high import conversions
from gpr20_operator.high.ros_events import RosEvents
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.robots import RobotReported, RobotsFound

PERIOD_S = 3.0


class RobotsClient(RosEvents):
    """Asks the master for the robots, and listens to those while somebody looks at the list."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._found: FrozenSet[str] = frozenset()
        self._statuses: Dict[str, rospy.Subscriber] = {}

    def listen(self) -> None:
        """Begin to ask the master."""
        self._periodic = Periodic(PERIOD_S, self._ask_master)

    def _ask_master(self) -> None:
        try:
            _publishers, _subscribers, services = rosgraph.Master(rospy.get_name()).getSystemState()
        except (rosgraph.MasterException, OSError):
            return  # the window says elsewhere that the master does not answer
        self._found = robots_on_master(name for name, _providers in services)
        self._emit(RobotsFound(self._found))
        self._follow()

    def _follow(self) -> None:
        with self._following:
            wanted = self._found if self._watched else frozenset()
            for namespace in set(self._statuses) - wanted:
                self._statuses.pop(namespace).unregister()
            for namespace in wanted - set(self._statuses):
                topic = rosgraph.names.ns_join(namespace, "control_status")
                received = partial(self._on_status, namespace)
                self._statuses[namespace] = rospy.Subscriber(topic, ControlStatus, received)

    def _on_status(self, namespace: str, message: ControlStatus) -> None:
        senders = Senders(f"{namespace.rstrip('/')}/")
        if senders.takes(connection_header(message)["callerid"]):
            self._emit(RobotReported(namespace, conversions.control_state(message)))
