"""One connection to a service; everything on it has a time limit."""

from __future__ import annotations

import io
import socket
import struct
import time
from typing import Any, Dict, Optional

import genpy
import rosgraph.network
import rospy

from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.low.tcp_keepalive import acknowledge_at_once, send_at_once

# SO_LINGER: on, for 0 s. Closing then discards what was not delivered yet.
DISCARD = struct.pack("ii", 1, 0)
LENGTH = struct.Struct("<I")
# In front of a response: whether the service returned one, and its length.
RESPONSE_HEAD = struct.Struct("<?I")
# No response is longer; the length of one that is not whole may be any number.
LONGEST_RESPONSE_BYTES = 1 << 30
PIECE_BYTES = 1 << 16
# A time limit of 0 would mean something else to a socket [s].
SHORTEST_WAIT_S = 1.0e-3


class ServiceConnection:
    """A connection for one call, or for several that follow each other.

    `rospy.ServiceProxy` connects and receives without a time limit, and what it has sent into a
    broken link arrives when the link is back: a request to move or to stop that was given up
    would be carried out minutes later. `abort` discards it.
    """

    def __init__(self, name: str, service_class: Any, persistent: bool = False) -> None:
        """Connect to nothing yet.

        Args:
            name: Name of the service, relative to this node's namespace.
            service_class: Its generated class.
            persistent: Whether the service expects more than one request.
        """
        self._name = rospy.resolve_name(name)
        self._service_class = service_class
        self._persistent = persistent
        self._socket: Optional[socket.socket] = None

    def connect(self, uri: str, timeout_s: float, answer_timeout_s: float) -> None:
        """Connect to the service.

        Args:
            uri: Its address, as the master knows it.
            timeout_s: Time limit for the connection [s].
            answer_timeout_s: Time limit for its node to accept it [s].

        Raises:
            OSError: There is no connection.
            rospy.ROSException: It is not that service.
        """
        self._socket = socket.create_connection(rospy.core.parse_rosrpc_uri(uri), timeout_s)
        deadline_s = time.monotonic() + answer_timeout_s
        send_at_once(self._socket)
        self._socket.sendall(rosgraph.network.encode_ros_handshake_header(self._header()))
        (length,) = LENGTH.unpack(self._receive(LENGTH.size, deadline_s))
        answer = LENGTH.pack(length) + self._receive(length, deadline_s)
        try:
            header = rosgraph.network.decode_ros_handshake_header(answer)
        except rosgraph.network.ROSHandshakeException as error:
            raise rospy.ROSException(str(error)) from error
        if "error" in header:
            raise rospy.ROSException(header["error"])

    def call(self, request: genpy.Message, timeout_s: float) -> Any:
        """Call the service and return its response.

        Args:
            request: The request.
            timeout_s: Time limit [s].

        Raises:
            OSError: The connection ended before the answer, or there was none in time.
            rospy.ServiceException: The service failed.
        """
        deadline_s = time.monotonic() + timeout_s
        data = serialized(request)
        connection = self._open_socket()
        connection.settimeout(max(timeout_s, SHORTEST_WAIT_S))
        connection.sendall(LENGTH.pack(len(data)) + data)
        returned, length = RESPONSE_HEAD.unpack(self._receive(RESPONSE_HEAD.size, deadline_s))
        answer = self._receive(length, deadline_s)
        if not returned:
            raise rospy.ServiceException(answer.decode(errors="replace"))
        return deserialized(self._service_class._response_class, answer)

    def is_open(self) -> bool:
        """Return whether the service has not ended the connection, as far as is known here."""
        try:
            connection = self._open_socket()
            connection.setblocking(False)
            connection.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return True
        except OSError:
            return False
        # The end of the connection, or an answer to nothing.
        return False

    def abort(self) -> None:
        """End the connection; what was not delivered yet is discarded."""
        if self._socket is not None and self._socket.fileno() >= 0:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, DISCARD)
        self.close()

    def close(self) -> None:
        """End the connection; what was sent is still delivered."""
        if self._socket is not None:
            self._socket.close()

    def _header(self) -> Dict[str, str]:
        header = {
            "service": self._name,
            "md5sum": self._service_class._md5sum,
            "callerid": rospy.get_caller_id(),
        }
        if self._persistent:
            header["persistent"] = "1"
        return header

    def _receive(self, size: int, deadline_s: float) -> bytes:
        """Return exactly so many bytes.

        Raises:
            OSError: The connection ended before, or they did not come in time.
        """
        if size > LONGEST_RESPONSE_BYTES:
            raise OSError(f"an answer of {size} bytes is announced")
        connection = self._open_socket()
        received = io.BytesIO()
        while received.tell() < size:
            connection.settimeout(max(deadline_s - time.monotonic(), SHORTEST_WAIT_S))
            # Asked for each time: the kernel forgets it. A server that has more to send waits for
            # the acknowledgement of the first part.
            acknowledge_at_once(connection)
            piece = connection.recv(min(size - received.tell(), PIECE_BYTES))
            if not piece:
                raise ConnectionResetError("the connection ended before the answer")
            received.write(piece)
        return received.getvalue()

    def _open_socket(self) -> socket.socket:
        if self._socket is None or self._socket.fileno() < 0:
            raise ConnectionAbortedError("the connection is closed")
        return self._socket
