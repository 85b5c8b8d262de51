"""Calling a service without ever waiting for it for ever."""

from __future__ import annotations

import queue
import threading
from typing import Any, Set

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message

# A node that is being started again offers its services within this time [s].
START_LIMIT_S = 10.0


class ServiceUnavailableError(Gpr20Error, OSError):
    """A service is not there, died while it was asked, or did not answer in time."""


class ServiceClient:
    """One service of another node; every call has a time limit.

    `rospy.ServiceProxy` has none: a node that hangs would hang its caller.
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self._name = name
        self._service_class = service_class
        self._lock = threading.Lock()
        self._waiting: Set[threading.Event] = set()

    @property
    def name(self) -> str:
        """The name the service was given, relative to this node's namespace."""
        return self._name

    def call(self, timeout_s: float, *request: Any, **fields: Any) -> Any:
        """Call the service and return its response, whatever it says.

        Args:
            timeout_s: Time limit for the whole call [s].
            request: The request, if its fields are not given.
            fields: Fields of the request.

        Raises:
            ServiceUnavailableError: No answer came; the message says why.
        """
        answers: queue.Queue = queue.Queue(maxsize=1)
        given_up = threading.Event()
        with self._lock:
            self._waiting.add(given_up)
        # The thread outlives a call that never returns; being a daemon it ends with the node.
        threading.Thread(
            target=self._ask, args=(timeout_s, (request, fields), answers, given_up), daemon=True
        ).start()
        try:
            answer = answers.get(timeout=timeout_s)
        except queue.Empty:
            given_up.set()
            raise ServiceUnavailableError(
                Message(
                    "the service {service} did not answer within {limit_s:g} s; check that its "
                    "node is running and not hung",
                    service=self._name,
                    limit_s=timeout_s,
                )
            ) from None
        finally:
            with self._lock:
                self._waiting.discard(given_up)
        if isinstance(answer, Exception):
            raise ServiceUnavailableError(
                Message(
                    "the service {service} could not be called; check that its node is running",
                    service=self._name,
                    details=answer,
                )
            ) from answer
        return answer

    def give_up(self) -> None:
        """Let calls that wait for the service's node never be made; one that was made continues."""
        with self._lock:
            for given_up in self._waiting:
                given_up.set()

    def _ask(
        self, timeout_s: float, arguments: Any, answers: queue.Queue, given_up: threading.Event
    ) -> None:
        try:
            # By the time of day: it takes longer if the clock is set back meanwhile.
            rospy.wait_for_service(self._name, timeout=min(timeout_s, START_LIMIT_S))
            if given_up.is_set():
                raise rospy.ROSException("the call was given up")
            proxy = rospy.ServiceProxy(self._name, self._service_class)
            request, fields = arguments
            answers.put(proxy(*request, **fields))
        except (rospy.ROSException, rospy.ServiceException, OSError) as error:
            answers.put(error)
