"""Calling a service without ever waiting for it for ever."""

from __future__ import annotations

import itertools
import queue
import threading
from dataclasses import dataclass, field
from typing import Any, Dict, List, Tuple

import rosgraph
import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.service_connection import ServiceConnection
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message

# A node that is being started again offers its services within this time [s].
START_LIMIT_S = 10.0
RETRY_S = 0.3


class ServiceUnavailableError(Gpr20Error, OSError):
    """A service is not there, died while it was asked, or did not answer in time."""


@dataclass
class Call:
    """One call of a service.

    Attributes:
        request: The request, if its fields are not given.
        fields: Fields of the request.
        deadline_s: When it must have ended [s].
        connection: Its connection.
        given_up: Set when it must not be made any more.
    """

    request: Tuple[Any, ...]
    fields: Dict[str, Any]
    deadline_s: float
    connection: ServiceConnection
    given_up: threading.Event = field(default_factory=threading.Event)


class ServiceClient:
    """One service of another node; every call has a time limit.

    `rospy.ServiceProxy` has none: a node that hangs would hang its caller.
    """

    def __init__(self, name: str, service_class: Any, discard_late: bool = True) -> None:
        """Connect to nothing yet.

        Args:
            name: Name of the service, relative to this node's namespace.
            service_class: Its generated class.
            discard_late: Whether a request that is not delivered in time is discarded.
        """
        self._discard_late = discard_late
        self._name = name
        self._service_class = service_class
        self._clock = Clock()
        self._lock = threading.Lock()
        self._calls: List[Call] = []

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
        deadline_s = self._clock.now_s() + timeout_s
        connection = ServiceConnection(self._name, self._service_class)
        call = Call(request, fields, deadline_s, connection)
        with self._lock:
            self._calls.append(call)
        # Being a daemon the thread ends with the node, whatever it waits for.
        threading.Thread(target=self._answer, args=(call, answers), daemon=True).start()
        try:
            answer = answers.get(timeout=timeout_s)
        except queue.Empty:
            if self._discard_late:
                call.given_up.set()
                connection.abort()
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
                self._calls.remove(call)
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
            for call in self._calls:
                call.given_up.set()

    def _answer(self, call: Call, answers: queue.Queue) -> None:
        try:
            self._connect(call)
            if call.given_up.is_set():
                call.connection.abort()
                raise rospy.ROSException("the call was given up")
            answers.put(call.connection.call(*call.request, **call.fields))
        except (rospy.ROSException, rospy.ServiceException, OSError) as error:
            answers.put(error)

    def _connect(self, call: Call) -> None:
        """Connect to the service; its node may be starting."""
        begun_s = self._clock.now_s()
        for attempt in itertools.count():
            try:
                remaining_s = call.deadline_s - self._clock.now_s()
                call.connection.connect(self._look_up(attempt), max(remaining_s, RETRY_S))
                return
            except (rosgraph.MasterException, rospy.ROSException, OSError) as error:
                failure = error
            if call.given_up.is_set() or rospy.is_shutdown():
                raise rospy.ROSException("the call was given up") from failure
            if self._clock.now_s() + RETRY_S > min(call.deadline_s, begun_s + START_LIMIT_S):
                raise rospy.ROSException(str(failure)) from failure
            self._clock.wait_s(call.given_up, RETRY_S)

    def _look_up(self, _attempt: int) -> str:
        """Return the address of the service, as the master knows it now."""
        master = rosgraph.Master(rospy.get_name())
        return str(master.lookupService(rospy.resolve_name(self._name)))
