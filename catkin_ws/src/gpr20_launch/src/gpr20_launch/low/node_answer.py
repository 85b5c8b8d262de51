"""Whether the process of a node on this computer answers."""

from __future__ import annotations

import enum
import socket
import xmlrpc.client
from typing import Optional
from urllib.parse import urlsplit

from gpr20_common.low.links import NO_ANSWER, limited_server, value_of

CALLER = "/watchdog"


class Answer(enum.Enum):
    """What is known of a process."""

    ALIVE = "it answers"
    SILENT = "it takes requests and does not answer them"
    MUTE = "the master knows it, and it has answered no request yet"
    UNKNOWN = "it could not be asked"


class NodeAnswer:
    """Asks one process, again and again."""

    def __init__(self, master_uri: str, name: str, number: int, time_limit_s: float) -> None:
        """Connect to nothing yet; the limit [s] is that of each step of a request."""
        self._master = limited_server(master_uri, time_limit_s)
        self._name = name
        self._number = number
        self._time_limit_s = time_limit_s
        self._host = ""
        # A process keeps its address: once confirmed, it needs no master any more.
        self._confirmed: Optional[xmlrpc.client.ServerProxy] = None

    def ask(self) -> Answer:
        """Return whether it answers.

        It is silent or mute only at an address that this computer still has: what is wrong with
        the network or the master is another matter.
        """
        try:
            server = self._confirmed or self._find()
        except NO_ANSWER:
            return Answer.UNKNOWN
        try:
            is_same = value_of(server.getPid(CALLER)) == self._number
        except NO_ANSWER as error:
            if self._confirmed is None:
                # Nobody listens: the master knows the address of the process before it.
                is_silent = isinstance(error, (socket.timeout, ConnectionRefusedError))
                unanswered = Answer.MUTE
            else:
                is_silent, unanswered = isinstance(error, socket.timeout), Answer.SILENT
            return unanswered if is_silent and _is_own(self._host) else Answer.UNKNOWN
        if not is_same:
            # A process that has just died may be known to the master under the same name.
            return Answer.UNKNOWN
        self._confirmed = server
        return Answer.ALIVE

    def _find(self) -> xmlrpc.client.ServerProxy:
        uri = str(value_of(self._master.lookupNode(CALLER, self._name)))
        self._host = str(urlsplit(uri).hostname)
        return limited_server(uri, self._time_limit_s)


def _is_own(host: str) -> bool:
    """Return whether this computer has an address, which it loses with the cable of a link."""
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError:
            return False
    return True
