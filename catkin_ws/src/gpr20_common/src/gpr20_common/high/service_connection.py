"""One connection to a service, which can be ended at any time."""

from __future__ import annotations

import socket
import struct
import threading
from typing import Any, Optional

import rosgraph.network
import rospy
from rospy.exceptions import TransportException
from rospy.impl.tcpros_base import TCPROSTransport

# SO_LINGER: on, for 0 s. Closing then discards what was not delivered yet.
DISCARD = struct.pack("ii", 1, 0)


class ServiceConnection:
    """The connection of one call.

    `rospy.ServiceProxy` connects and receives without a time limit, and what it has sent into a
    broken link arrives when the link is back: a request to move or to stop that was given up
    would be carried out minutes later. `abort` discards it.
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self._proxy = rospy.ServiceProxy(name, service_class)
        self._lock = threading.Lock()
        self._socket: Optional[socket.socket] = None
        self._aborted = False

    def connect(self, uri: str, timeout_s: float) -> None:
        """Connect to the service.

        Args:
            uri: Its address, as the master knows it.
            timeout_s: Time limit for the connection [s]; `abort` ends what follows.

        Raises:
            OSError: There is no connection.
            rospy.ROSException: It is not that service, or the call was aborted.
        """
        address = rospy.core.parse_rosrpc_uri(uri)
        connection = socket.create_connection(address, timeout_s)
        with self._lock:
            self._socket = connection
            if self._aborted:
                connection.close()
                raise rospy.ROSException("the call was aborted")
        transport = TCPROSTransport(self._proxy.protocol, self._proxy.resolved_name)
        transport.set_socket(connection, uri)
        try:
            transport.write_header()
            transport.read_header()
        except (TransportException, rosgraph.network.ROSHandshakeException) as error:
            transport.close()
            raise rospy.ROSException(str(error)) from error
        except OSError:
            transport.close()
            raise
        self._proxy.transport = transport

    def call(self, *request: Any, **fields: Any) -> Any:
        """Call the service and return its response; this ends the connection.

        Raises:
            rospy.ServiceException: The connection ended before the answer.
        """
        try:
            return self._proxy(*request, **fields)
        except TransportException as error:
            # rospy converts those of the answer, but not those of the request.
            raise rospy.ServiceException(str(error)) from error

    def abort(self) -> None:
        """End the connection in any thread; what was not delivered yet is discarded."""
        with self._lock:
            self._aborted = True
            if self._socket is None or self._socket.fileno() < 0:
                return
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, DISCARD)
            try:
                # The thread that waits for the answer closes it.
                self._socket.shutdown(socket.SHUT_RDWR)
            except OSError:
                # It is closed already.
                return
