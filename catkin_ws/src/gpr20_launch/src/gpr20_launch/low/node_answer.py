"""Whether the process of a node on this computer answers."""

from __future__ import annotations

import enum
import socket
from typing import Optional
from urllib.parse import urlsplit

from gpr20_common.low.limited_rpc import NO_ANSWER, limited_server, value_of
from gpr20_common.low.pid_query import PidQuery

CALLER = "/watchdog"


class Answer(enum.Enum):
    """What is known of a process."""

    ALIVE = "it answers"
    SILENT = "it takes requests and does not answer them"
    UNKNOWN = "it could not be asked"


class NodeAnswer:
    """Asks one process, again and again."""

    def __init__(self, master_uri: str, name: str, number: int, time_limit_s: float) -> None:
        """Connect to nothing yet.

        Args:
            master_uri: Where the master is.
            name: Full name of the node.
            number: Its process id.
            time_limit_s: For each step of a request [s].
        """
        self._master = limited_server(master_uri, time_limit_s)
        self._name = name
        self._number = number
        self._time_limit_s = time_limit_s
        self._host = ""
        # A process keeps its address: once confirmed, it needs no master any more.
        self._confirmed: Optional[PidQuery] = None

    def ask(self) -> Answer:
        """Return whether it answers.

        It is silent only if it has answered before, at an address that this computer still has:
        what is wrong with the network, the master or the start of a node is another matter.
        """
        if self._confirmed is None:
            return self._find()
        try:
            is_same = self._confirmed.ask() == self._number
        except socket.timeout:
            return Answer.SILENT if _is_own(self._host) else Answer.UNKNOWN
        except NO_ANSWER:
            return Answer.UNKNOWN
        return Answer.ALIVE if is_same else Answer.UNKNOWN

    def _find(self) -> Answer:
        try:
            uri = str(value_of(self._master.lookupNode(CALLER, self._name)))
            query = PidQuery(uri, CALLER, self._time_limit_s)
            # A process that has just died may be known to the master under the same name.
            if query.ask() != self._number:
                query.close()
                return Answer.UNKNOWN
        except NO_ANSWER:
            return Answer.UNKNOWN
        self._host = str(urlsplit(uri).hostname)
        self._confirmed = query
        return Answer.ALIVE


def _is_own(host: str) -> bool:
    """Return whether this computer has an address, which it loses with the cable of a link."""
    with socket.socket() as probe:
        try:
            probe.bind((host, 0))
        except OSError:
            return False
    return True
