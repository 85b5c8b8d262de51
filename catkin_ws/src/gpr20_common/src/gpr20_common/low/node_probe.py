"""Asking a node of the graph whether it is there."""

from __future__ import annotations

import http.client
import xmlrpc.client
from typing import Any, Optional
from xml.parsers.expat import ExpatError

from gpr20_common.errors import NodeSilentError
from gpr20_common.message import Message

SUCCESS = 1
# No connection, no HTTP, no XML, no XML-RPC, or not what ROS answers.
NO_ANSWER = (
    OSError,
    http.client.HTTPException,
    ExpatError,
    xmlrpc.client.Error,
    ValueError,
    TypeError,
)


class LimitedTransport(xmlrpc.client.Transport):
    """HTTP with a time limit for the connection and for each answer."""

    def __init__(self, time_limit_s: float) -> None:
        super().__init__()
        self._time_limit_s = time_limit_s

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return a connection, the former one if it is still open."""
        connection = super().make_connection(host)
        connection.timeout = self._time_limit_s
        return connection


class NodeProbe:
    """The XML-RPC interface that every ROS node has; not to be shared by threads."""

    def __init__(self, master_uri: str, caller_id: str, node: str, time_limit_s: float) -> None:
        """Connect to nothing yet.

        Args:
            master_uri: Where the master is.
            caller_id: Name of the node that asks.
            node: Full name of the node that is asked.
            time_limit_s: For each answer [s].
        """
        self._caller_id = caller_id
        self._node = node
        self._time_limit_s = time_limit_s
        self._master = self._server(master_uri)
        self._uri = ""
        self._server_of_node: Optional[xmlrpc.client.ServerProxy] = None

    def process(self) -> int:
        """Return the number of the node's process.

        Raises:
            NodeSilentError: It does not answer; the message says why.
        """
        try:
            if self._server_of_node is None:
                self._server_of_node = self._server(self._look_up())
            # The address is kept: a master that is gone does not make its nodes silent.
            return int(self._ask(self._server_of_node.getPid(self._caller_id)))
        except NO_ANSWER as error:
            self._server_of_node = None
            raise NodeSilentError(
                Message("{node} does not answer", node=self._node, details=error)
            ) from error

    def _look_up(self) -> str:
        return str(self._ask(self._master.lookupNode(self._caller_id, self._node)))

    def _ask(self, answer: Any) -> Any:
        code, message, value = answer
        if code != SUCCESS:
            raise ValueError(message)
        return value

    def _server(self, uri: str) -> xmlrpc.client.ServerProxy:
        return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(self._time_limit_s))
