"""XML-RPC with time limits, as the master and every node speak it."""

from __future__ import annotations

import http.client
import xmlrpc.client
from typing import Any
from xml.parsers.expat import ExpatError

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


def limited_server(uri: str, time_limit_s: float) -> xmlrpc.client.ServerProxy:
    """Return the interface at an address; each step of a call has a time limit [s]."""
    return xmlrpc.client.ServerProxy(uri, transport=LimitedTransport(time_limit_s))


def value_of(answer: Any) -> Any:
    """Return the value of an answer.

    Raises:
        ValueError: It reports a failure.
    """
    code, message, value = answer
    if code != SUCCESS:
        raise ValueError(message)
    return value
