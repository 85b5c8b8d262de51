"""A service that is reached without the ROS master once its address is known."""

from __future__ import annotations

import queue
import threading
from typing import Any

import rosgraph
import rospy

from gpr20_common.high.service_client import ServiceClient


class DirectServiceClient(ServiceClient):
    """Keeps the address of a service: STOP must work while the master is away."""

    def __init__(self, name: str, service_class: Any) -> None:
        super().__init__(name, service_class)
        self._address = ""

    def remember(self) -> None:
        """Ask the master where the service is; one that is not there keeps its last address.

        Raises:
            OSError: The master does not answer.
            rosgraph.MasterException: Its answer makes no sense.
        """
        master = rosgraph.Master(rospy.get_name())
        try:
            self._address = master.lookupService(rospy.resolve_name(self.name))
        except rosgraph.MasterError:
            # Nobody offers it now.
            return

    def _ask(
        self, timeout_s: float, fields: Any, answers: queue.Queue, given_up: threading.Event
    ) -> None:
        if not self._address:
            super()._ask(timeout_s, fields, answers, given_up)
            return
        try:
            proxy = _AddressedProxy(self.name, self._service_class, self._address)
            answers.put(proxy(**fields))
        except (rospy.ROSException, rospy.ServiceException, OSError):
            # It is not there any more, or has another address: the master may know.
            super()._ask(timeout_s, fields, answers, given_up)


class _AddressedProxy(rospy.ServiceProxy):
    def __init__(self, name: str, service_class: Any, address: str) -> None:
        super().__init__(name, service_class)
        self._address = address

    def _get_service_uri(self, _request: Any) -> str:
        return self._address
