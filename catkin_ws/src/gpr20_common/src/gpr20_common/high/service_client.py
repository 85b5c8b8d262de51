"""Calling a service without ever waiting for it for ever."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
import time
from typing import Any, Dict, List, Optional

import genpy
import rosgraph
import rospy
from rosgraph import network

from gpr20_common.errors import NodeSilentError
from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.low.links import NO_ANSWER, limited_server, value_of
from gpr20_common.message import Message

# A node that is being started again offers its services within this time [s].
START_LIMIT_S = 10.0
RETRY_S = 0.3
# A connection is used again for so long after an answer [s]. A node that takes the name of one that
# hangs waits for longer before it starts (`node.ANSWER_LIMIT_S`), so the process that answered is
# still the one that offers the service; after that the master is asked.
REUSE_S = 0.8
# SO_LINGER: on, for 0 s. Closing then discards what was not delivered yet.
DISCARD = struct.pack("ii", 1, 0)
LENGTH = struct.Struct("<I")
# In front of a response: whether the service returned one, and its length.
RESPONSE_HEAD = struct.Struct("<?I")
PIECE_BYTES = 1 << 16
# Why there is no connection.
NOT_CONNECTED = (*NO_ANSWER, rospy.ROSException, network.ROSHandshakeException)
# Why there is no answer.
FAILURES = (*NOT_CONNECTED, rospy.ServiceException, genpy.MessageException)
GIVEN_UP = "the call was given up"


class ServiceUnavailableError(NodeSilentError):
    """A service is not there, died while it was asked, or did not answer in time."""


class ServiceConnection:
    """A connection to a service; times are those of `time.monotonic`.

    `rospy.ServiceProxy` connects and receives without a time limit, and what it has sent into a
    broken link arrives when the link is back: a request to move or to stop that was given up
    would be carried out minutes later. `abort` discards it.
    """

    def __init__(self, uri: str, header: Dict[str, str], deadline_s: float) -> None:
        """Connect, and have the node accept it in time, or raise what `NOT_CONNECTED` has."""
        address = rospy.core.parse_rosrpc_uri(uri)
        self._socket = socket.create_connection(address, _remaining_s(deadline_s))
        try:
            # Small messages must not wait for the acknowledgement of earlier ones.
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.sendall(network.encode_ros_handshake_header(header))
            (length,) = LENGTH.unpack(self._receive(LENGTH.size, deadline_s))
            answer = LENGTH.pack(length) + self._receive(length, deadline_s)
            found = network.decode_ros_handshake_header(answer)
            if "error" in found:
                raise rospy.ROSException(found["error"])
        except BaseException:
            self.abort()
            raise
        self.answered_s = time.monotonic()

    def call(self, request: genpy.Message, deadline_s: float) -> bytes:
        """Return the response, serialized, or raise what `FAILURES` has."""
        data = serialized(request)
        self._socket.settimeout(_remaining_s(deadline_s))
        self._socket.sendall(LENGTH.pack(len(data)) + data)
        returned, length = RESPONSE_HEAD.unpack(self._receive(RESPONSE_HEAD.size, deadline_s))
        answer = self._receive(length, deadline_s)
        if not returned:
            raise rospy.ServiceException(answer.decode(errors="replace"))
        self.answered_s = time.monotonic()
        return answer

    def is_open(self) -> bool:
        """Return whether the service has neither ended it nor sent an answer to nothing."""
        self._socket.setblocking(False)
        try:
            self._socket.recv(1, socket.MSG_PEEK)
        except OSError as error:
            return isinstance(error, BlockingIOError)
        return False

    def abort(self) -> None:
        """End the connection; what was not delivered yet is discarded."""
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, DISCARD)
        self.close()

    def close(self) -> None:
        self._socket.close()

    def _receive(self, size: int, deadline_s: float) -> bytes:
        received = bytearray()
        while len(received) < size:
            self._socket.settimeout(_remaining_s(deadline_s))
            # Asked for each time: the kernel forgets it. A server that has more to send waits for
            # the acknowledgement of the first part.
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            piece = self._socket.recv(min(size - len(received), PIECE_BYTES))
            if not piece:
                raise ConnectionResetError("the connection ended before the answer")
            received += piece
        return bytes(received)


class ServiceClient:
    """One service of another node; several threads may call it at once."""

    def __init__(self, name: str, service_class: Any, keep_open: bool = False) -> None:
        """Connect to nothing yet; the name is relative to this node's namespace.

        With `keep_open` calls that soon follow each other use one connection; a node that hung may
        then carry out what was given up: not for requests that move anything.
        """
        self.name = name
        self._keep_open = keep_open
        self._service_class = service_class
        self._given_up = threading.Event()
        self._kept: List[ServiceConnection] = []

    def call(self, timeout_s: float, *request: Any, **fields: Any) -> Any:
        """Return the response to a request, or to one with these fields, whatever it says.

        A ServiceUnavailableError says why no answer came in time [s].
        """
        kind = self._service_class
        message = rospy.msg.args_kwds_to_message(kind._request_class, request, fields)
        try:
            return deserialized(kind._response_class, self._make(message, timeout_s))
        except FAILURES as error:
            text = Message(
                "the service {service} could not be called, or did not answer within {limit_s:g} "
                "s; check that its node is running and not hung",
                service=self.name,
                limit_s=timeout_s,
                details=error,
            )
            raise ServiceUnavailableError(text) from error

    def give_up(self) -> None:
        """Let calls that wait for the service's node never be made; one that was made continues."""
        given_up, self._given_up = self._given_up, threading.Event()
        given_up.set()

    def _make(self, request: genpy.Message, timeout_s: float) -> bytes:
        given_up, deadline_s = self._given_up, time.monotonic() + timeout_s
        connection = self._take_kept() or self._connect(deadline_s, given_up)
        try:
            if given_up.is_set():
                raise rospy.ROSException(GIVEN_UP)
            response = connection.call(request, deadline_s)
        except BaseException:
            connection.abort()
            raise
        if self._keep_open:
            self._kept.append(connection)
        else:
            connection.close()
        return response

    def _take_kept(self) -> Optional[ServiceConnection]:
        with contextlib.suppress(IndexError):  # another thread may take the last one
            while True:
                kept = self._kept.pop()
                if time.monotonic() - kept.answered_s < REUSE_S and kept.is_open():
                    return kept
                kept.close()
        return None

    def _connect(self, deadline_s: float, given_up: threading.Event) -> ServiceConnection:
        """Connect to the service; its node may be starting."""
        header = {
            "service": rospy.resolve_name(self.name),
            "md5sum": self._service_class._md5sum,
            "callerid": rospy.get_caller_id(),
            **({"persistent": "1"} if self._keep_open else {}),
        }
        last_s = min(deadline_s, time.monotonic() + START_LIMIT_S) - RETRY_S
        attempt = 0
        while True:
            try:
                uri = self._look_up(attempt, _remaining_s(deadline_s))
                return ServiceConnection(uri, header, deadline_s)
            except NOT_CONNECTED as error:
                if given_up.is_set() or rospy.is_shutdown():
                    raise rospy.ROSException(GIVEN_UP) from error
                if time.monotonic() > last_s:
                    raise
            attempt += 1
            given_up.wait(RETRY_S)

    def _look_up(self, _attempt: int, limit_s: float) -> str:
        master = limited_server(rosgraph.get_master_uri(), limit_s)
        name = rospy.resolve_name(self.name)
        return str(value_of(master.lookupService(rospy.get_caller_id(), name)))


def _remaining_s(deadline_s: float) -> float:
    """Return the time that is left [s], or raise a socket.timeout."""
    remaining_s = deadline_s - time.monotonic()
    if remaining_s <= 0.0:
        raise socket.timeout("timed out")
    return remaining_s
