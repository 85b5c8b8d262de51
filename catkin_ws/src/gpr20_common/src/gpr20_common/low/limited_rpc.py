"""XML-RPC with time limits, as the master and every node speak it."""

from __future__ import annotations

import contextlib
import xmlrpc.client
from http.client import HTTPConnection, HTTPException
from typing import Any, Optional
from xml.parsers.expat import ExpatError

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.message import Message

SUCCESS = 1
# No connection, no HTTP, no XML, no XML-RPC, or not what ROS answers.
NO_ANSWER = (OSError, HTTPException, ExpatError, xmlrpc.client.Error, ValueError, TypeError)


class LimitedTransport(xmlrpc.client.Transport):
    def __init__(self, time_limit_s: float) -> None:
        super().__init__()
        self._time_limit_s = time_limit_s

    def make_connection(self, host: Any) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._time_limit_s
        return connection


def limited_server(uri: str, time_limit_s: float) -> xmlrpc.client.ServerProxy:
    """Return the interface at an address; each step of a call has a time limit [s].

    Its connection is kept for further calls, and made again if the other side has ended it.
    """
    return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(time_limit_s))


def value_of(answer: Any) -> Any:
    """Return the value of an answer; raises a ValueError if it reports a failure."""
    code, message, value = answer
    if code != SUCCESS:
        raise ValueError(message)
    return value


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
        """Return the number of the node's process.

        Raises:
            NodeGoneError: It has ended; the message says how that is known.
            NodeSilentError: It does not answer; the message says why.
        """
        known, self._server = self._server, None
        try:
            if known is not None:
                # The process that took its place has another address.
                with contextlib.suppress(ConnectionRefusedError):
                    return self._ask(known)
            return self._ask(limited_server(self._look_up(), self._time_limit_s))
        except NodeSilentError:
            raise
        except NO_ANSWER as error:
            kind = NodeGoneError if isinstance(error, ConnectionRefusedError) else NodeSilentError
            raise kind(self._silence(error)) from error

    def _ask(self, server: xmlrpc.client.ServerProxy) -> int:
        number = int(value_of(server.getPid(self._caller_id)))
        self._server = server
        return number

    def _look_up(self) -> str:
        try:
            return str(value_of(self._master.lookupNode(self._caller_id, self._node)))
        except NO_ANSWER as error:
            # A master that refuses connections says nothing about the node.
            kind = NodeGoneError if isinstance(error, ValueError) else NodeSilentError
            raise kind(self._silence(error)) from error

    def _silence(self, error: Exception) -> Message:
        return Message("{node} does not answer", node=self._node, details=error)
