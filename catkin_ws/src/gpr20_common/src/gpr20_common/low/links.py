"""Links that may break: XML-RPC with time limits, and TCP connections that notice it."""

from __future__ import annotations

import contextlib
import socket
import xmlrpc.client
from http.client import HTTPConnection, HTTPException
from typing import Any, Optional, Type
from xml.parsers.expat import ExpatError

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.message import Message

# No connection, no HTTP, no XML, no XML-RPC, or not what ROS answers.
NO_ANSWER = (OSError, HTTPException, ExpatError, xmlrpc.client.Error, ValueError, TypeError)

# An idle connection is probed this often [s]; the other end's kernel answers, however busy
# its programs are.
PROBE_PERIOD_S = 1
# As many unanswered probes as Linux allows end the connection, after two minutes as in rospy:
# until then a cable that is plugged in again finds it alive.
MOST_PROBES = 127


def limited_server(uri: str, time_limit_s: float) -> xmlrpc.client.ServerProxy:
    """Return the interface at an address; each step of a call has a time limit [s].

    Its connection is kept for further calls, and made again if the other side has ended it.
    """

    class Limited(xmlrpc.client.Transport):
        def make_connection(self, host: Any) -> HTTPConnection:
            connection = super().make_connection(host)
            connection.timeout = time_limit_s
            return connection

    return xmlrpc.client.ServerProxy(uri, transport=Limited())


def value_of(answer: Any) -> Any:
    """Return the value of an answer; raises a ValueError if it reports a failure."""
    code, message, value = answer
    if code != 1:
        raise ValueError(message)
    return value


def answers(uri: str, caller_id: str, time_limit_s: float) -> bool:
    """Return whether a node or the master answers at an address."""
    with contextlib.suppress(*NO_ANSWER):
        value_of(limited_server(uri, time_limit_s).getPid(caller_id))
        return True
    return False


class NodeProbe:
    """Asks a node of the graph whether it is there; not to be shared by threads."""

    def __init__(self, master_uri: str, caller_id: str, node: str, time_limit_s: float) -> None:
        """Connect to nothing yet; the names are full ones, the limit is for each answer [s]."""
        self._caller_id = caller_id
        self._node = node
        self._time_limit_s = time_limit_s
        self._master = limited_server(master_uri, time_limit_s)
        # The address is kept: a master that is gone does not make its nodes silent.
        self._server: Optional[xmlrpc.client.ServerProxy] = None

    def process(self) -> int:
        """Return the number of the node's process; a NodeSilentError says why there is none."""
        known, self._server = self._server, None
        # What says that it has ended; a master that refuses connections says nothing of the node.
        gone: Type[Exception] = ConnectionRefusedError
        try:
            if known is not None:
                # The process that took its place has another address.
                with contextlib.suppress(ConnectionRefusedError):
                    return self._ask(known)
            gone = ValueError
            uri = str(value_of(self._master.lookupNode(self._caller_id, self._node)))
            gone = ConnectionRefusedError
            return self._ask(limited_server(uri, self._time_limit_s))
        except NO_ANSWER as error:
            kind = NodeGoneError if isinstance(error, gone) else NodeSilentError
            message = Message("{node} does not answer", node=self._node, details=error)
            raise kind(message) from error

    def _ask(self, server: xmlrpc.client.ServerProxy) -> int:
        number = int(value_of(server.getPid(self._caller_id)))
        self._server = server
        return number


# Each of these raises an OSError if the connection is closed.


def keep_alive(connection: socket.socket) -> None:
    """Have the kernel ask the other end for a sign of life every `PROBE_PERIOD_S`."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, PROBE_PERIOD_S)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, PROBE_PERIOD_S)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, MOST_PROBES)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)


def end_when_broken(connection: socket.socket, limit_s: float) -> None:
    """Have the kernel end the connection when the other end has not answered for a time [s].

    Without this limit a connection over a link that was down stays silent for as long again:
    Linux doubles the time between its attempts to send.
    """
    keep_alive(connection)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, round(1e3 * limit_s))
