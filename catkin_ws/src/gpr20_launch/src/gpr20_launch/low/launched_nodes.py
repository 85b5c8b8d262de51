"""The nodes that the roslaunch of this process has started, and whether each of them answers."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import xmlrpc.client
from typing import Collection, Dict, Optional, Tuple
from urllib.parse import urlsplit

from gpr20_common.low.links import NO_ANSWER, limited_server, value_of
from gpr20_doctor.low.masters import is_here
from gpr20_doctor.low.processes import PROC, Process, all_processes, process_of

CALLER = "/watchdog"
WORKING = frozenset("RD")


class LaunchedNodes:
    """The nodes beside this process: children of the same roslaunch on this computer."""

    def __init__(
        self, parent: int, word: str, others: Collection[str], master: str, time_limit_s: float
    ) -> None:
        """Look at nothing yet.

        Args:
            parent: Process id of the roslaunch.
            word: A node is one of ours if its command line has this word,
            others: or if its full name is one of these.
            master: Address of the master.
            time_limit_s: For each step of a request [s].
        """
        self._parent = parent
        self._word = word
        self._others = frozenset(others)
        self._master = limited_server(master, time_limit_s)
        self._time_limit_s = time_limit_s
        # A process keeps its address: once confirmed, it needs no master any more.
        self._confirmed: Dict[Tuple[int, str], Tuple[str, xmlrpc.client.ServerProxy]] = {}

    def find(self) -> Dict[int, str]:
        """Return the full name of each node, by its process id."""
        named = {one.number: self._name(one) for one in all_processes()}
        found = {number: name for number, name in named.items() if name and number != os.getpid()}
        self._confirmed = {key: one for key, one in self._confirmed.items() if key in found.items()}
        return found

    def answers(self, number: int, name: str) -> Optional[bool]:
        """Return whether a node that has answered before does; None if it could not be asked.

        It does not only at an address that this computer still has: what is wrong with the
        network or the master is another matter.
        """
        known = self._confirmed.get((number, name))
        try:
            uri, server = known or self._find(name)
            if value_of(server.getPid(CALLER)) != number:
                # A process that has just died may be known to the master under the same name.
                return None
        except socket.timeout:
            # A computer loses its address with the cable of a link.
            return False if known and is_here(urlsplit(known[0]).hostname or "") else None
        except NO_ANSWER:
            return None
        self._confirmed[number, name] = uri, server
        return True

    def is_working(self, number: int) -> bool:
        """Return whether a thread of the process runs, waits for a processor, or for a disk."""
        return any(one.state in WORKING for one in all_processes(PROC / str(number) / "task"))

    def kill(self, number: int, name: str) -> None:
        """End the process, if it is still that of the node."""
        process = process_of(number)
        if process is not None and self._name(process) == name:
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(number, signal.SIGKILL)

    def _name(self, process: Process) -> str:
        if process.parent != self._parent or not process.node:
            return ""
        name = f"/{process.variable('ROS_NAMESPACE').strip('/')}/{process.node}".replace("//", "/")
        return name if self._word in process.words or name in self._others else ""

    def _find(self, name: str) -> Tuple[str, xmlrpc.client.ServerProxy]:
        uri = str(value_of(self._master.lookupNode(CALLER, name)))
        return uri, limited_server(uri, self._time_limit_s)
