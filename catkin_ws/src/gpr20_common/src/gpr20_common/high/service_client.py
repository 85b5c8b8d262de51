"""Calling a service without ever waiting for it for ever."""

from __future__ import annotations

import itertools
import queue
import socket
import threading
from dataclasses import dataclass, field
from typing import Any, List, Optional

import genpy
import rosgraph
import rospy

from gpr20_common import faults
from gpr20_common.errors import Gpr20Error
from gpr20_common.high.service_connection import ServiceConnection
from gpr20_common.low.clock import Clock
from gpr20_common.low.limited_rpc import NO_ANSWER, limited_server, value_of
from gpr20_common.message import Message

# A node that is being started again offers its services within this time [s].
START_LIMIT_S = 10.0
RETRY_S = 0.3
# A connection is used again for so long after an answer [s]. A node that takes the name of one that
# hangs waits for longer before it starts (`node.ANSWER_LIMIT_S`), so the process that answered is
# still the one that offers the service; after that the master is asked.
REUSE_S = 0.8
# A request whose delivery counts more than its answer waits for so long for a node that hangs [s].
LATE_LIMIT_S = 900.0


class ServiceUnavailableError(Gpr20Error, OSError):
    """A service is not there, died while it was asked, or did not answer in time."""

    fault = faults.SERVICE_UNAVAILABLE


@dataclass(eq=False)
class Call:
    """One call of a service.

    Attributes:
        deadline_s: When it must be made [s].
        answer_deadline_s: When the answer must have come [s].
        given_up: Set when it must not be made any more.
    """

    deadline_s: float
    answer_deadline_s: float
    given_up: threading.Event = field(default_factory=threading.Event)


@dataclass(frozen=True)
class _KeptConnection:
    """A connection that waits for the next call, and when its last answer came [s]."""

    connection: ServiceConnection
    answered_s: float


class ServiceClient:
    """One service of another node; every call has a time limit.

    `rospy.ServiceProxy` has none: a node that hangs would hang its caller. Calls are made in the
    thread of the caller, in parallel if several threads call.
    """

    def __init__(
        self, name: str, service_class: Any, discard_late: bool = True, keep_open: bool = False
    ) -> None:
        """Connect to nothing yet.

        Args:
            name: Name of the service, relative to this node's namespace.
            service_class: Its generated class.
            discard_late: Whether a request that is not delivered in time is discarded.
            keep_open: Whether a connection is used for calls that soon follow each other. A node
                that hangs may carry out such a request when it no longer does, because it need
                not accept a connection first: not for requests that move anything.
        """
        self._discard_late = discard_late
        self._keep_open = keep_open
        self._name = name
        self._service_class = service_class
        self._clock = Clock()
        self._lock = threading.Lock()
        self._calls: List[Call] = []
        self._kept: List[_KeptConnection] = []

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
        message = rospy.msg.args_kwds_to_message(
            self._service_class._request_class, request, fields
        )
        try:
            return (
                self._make(message, timeout_s)
                if self._discard_late
                else self._deliver(message, timeout_s)
            )
        except socket.timeout as error:
            raise ServiceUnavailableError(
                Message(
                    "the service {service} did not answer within {limit_s:g} s; check that its "
                    "node is running and not hung",
                    service=self._name,
                    limit_s=timeout_s,
                ),
                fault=faults.SERVICE_SILENT,
            ) from error
        except (
            rospy.ROSException,
            rospy.ServiceException,
            genpy.MessageException,
            OSError,
        ) as error:
            raise ServiceUnavailableError(
                Message(
                    "the service {service} could not be called; check that its node is running",
                    service=self._name,
                    details=error,
                )
            ) from error

    def prepare(self, timeout_s: float) -> None:
        """Connect now, so that a call that follows soon need not; for a client with `keep_open`.

        Nothing is requested. If there is no connection within the time limit [s], the call finds
        out why.
        """
        kept = self._take_kept()
        if kept is None:
            deadline_s = self._clock.now_s() + timeout_s
            try:
                connection = self._connect(Call(deadline_s, deadline_s))
            except (*NO_ANSWER, rospy.ROSException) as error:
                rospy.logdebug("the service %s cannot be prepared: %s", self._name, error)
                return
            kept = _KeptConnection(connection, self._clock.now_s())
        self._keep(kept)

    def give_up(self) -> None:
        """Let calls that wait for the service's node never be made; one that was made continues."""
        with self._lock:
            for call in self._calls:
                call.given_up.set()

    def _deliver(self, request: genpy.Message, timeout_s: float) -> Any:
        """Make a call that continues in a thread of its own when its time limit is over."""
        answers: queue.Queue = queue.Queue(maxsize=1)

        def make() -> None:
            try:
                answers.put(self._make(request, timeout_s, LATE_LIMIT_S))
            except Exception as error:  # raised again below
                answers.put(error)

        # Being a daemon it ends with the node, whatever it waits for.
        threading.Thread(target=make, daemon=True).start()
        try:
            answer = answers.get(timeout=timeout_s)
        except queue.Empty:
            raise socket.timeout("timed out") from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def _make(self, request: genpy.Message, timeout_s: float, late_s: float = 0.0) -> Any:
        deadline_s = self._clock.now_s() + timeout_s
        call = Call(deadline_s, deadline_s + late_s)
        with self._lock:
            self._calls.append(call)
        try:
            kept = self._take_kept()
            connection = self._connect(call) if kept is None else kept.connection
            return self._call_over(connection, call, request)
        finally:
            with self._lock:
                self._calls.remove(call)

    def _call_over(self, connection: ServiceConnection, call: Call, request: genpy.Message) -> Any:
        try:
            if call.given_up.is_set():
                raise rospy.ROSException("the call was given up")
            response = connection.call(request, self._remaining_s(call.answer_deadline_s))
        except BaseException:
            connection.abort()
            raise
        if self._keep_open:
            self._keep(_KeptConnection(connection, self._clock.now_s()))
        else:
            connection.close()
        return response

    def _keep(self, kept: _KeptConnection) -> None:
        with self._lock:
            self._kept.append(kept)

    def _take_kept(self) -> Optional[_KeptConnection]:
        """Return a connection over which an answer came just now; None if there is none."""
        while True:
            with self._lock:
                if not self._kept:
                    return None
                kept = self._kept.pop()
            recent = self._clock.now_s() - kept.answered_s < REUSE_S
            if recent and kept.connection.is_open():
                return kept
            kept.connection.close()

    def _connect(self, call: Call) -> ServiceConnection:
        """Connect to the service; its node may be starting."""
        begun_s = self._clock.now_s()
        for attempt in itertools.count():
            connection = ServiceConnection(self._name, self._service_class, self._keep_open)
            try:
                uri = self._look_up(attempt, self._remaining_s(call.deadline_s))
                answer_limit_s = self._remaining_s(call.answer_deadline_s)
                connection.connect(uri, self._remaining_s(call.deadline_s), answer_limit_s)
                return connection
            except (*NO_ANSWER, rospy.ROSException) as error:
                connection.abort()
                failure = error
            if call.given_up.is_set() or rospy.is_shutdown():
                raise rospy.ROSException("the call was given up") from failure
            if isinstance(failure, socket.timeout) and self._clock.now_s() >= call.deadline_s:
                raise failure
            if self._clock.now_s() + RETRY_S > min(call.deadline_s, begun_s + START_LIMIT_S):
                raise rospy.ROSException(str(failure)) from failure
            self._clock.wait_s(call.given_up, RETRY_S)
        raise AssertionError("numbers do not end")

    def _remaining_s(self, deadline_s: float) -> float:
        """Return the time that is left [s].

        Raises:
            socket.timeout: None is.
        """
        remaining_s = deadline_s - self._clock.now_s()
        if remaining_s <= 0.0:
            raise socket.timeout("timed out")
        return remaining_s

    def _look_up(self, _attempt: int, limit_s: float) -> str:
        """Return the address of the service, as the master knows it now."""
        master = limited_server(rosgraph.get_master_uri(), limit_s)
        name = rospy.resolve_name(self._name)
        return str(value_of(master.lookupService(rospy.get_caller_id(), name)))
