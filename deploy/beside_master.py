"""Run a command beside the ROS master of ROS_MASTER_URI and rosout, which are started again.

beside_master.py COMMAND ...

roslaunch ends with a master that it has started itself. Nodes whose master was started apart
continue when it dies, and fill the next one. A master that answers there already is used, and left
alone. SIGINT, SIGTERM and SIGHUP end the command with SIGINT, as Ctrl-C does, and then the master.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import uuid
from typing import List, Optional
from urllib.parse import urlsplit

from gpr20_common.low.links import answers, limited_server

POLL_S = 0.2
ANSWER_LIMIT_S = 3.0
NAME = "/gpr20_beside_master"
DEFAULT_PORT = 11311


class Master:
    """The master at an address with its rosout; none is started where one answers already."""

    def __init__(self, uri: str) -> None:
        self._uri = uri
        # What roslaunch gives each master. One that takes the place of another has the same.
        self._run = str(uuid.uuid1())
        self._master: Optional[subprocess.Popen[bytes]] = None
        self._rosout: Optional[subprocess.Popen[bytes]] = None
        self._is_ready = self._answers()
        self._is_own = not self._is_ready

    def keep(self) -> bool:
        """Start what has ended; return whether the master can be used."""
        if self._is_own and _has_ended(self._master):
            self._is_ready = False
            port = urlsplit(self._uri).port or DEFAULT_PORT
            self._master = _started("rosmaster", "--core", "-p", str(port))
        if not self._is_ready and self._answers():
            limited_server(self._uri, ANSWER_LIMIT_S).setParam(NAME, "/run_id", self._run)
            self._is_ready = True
        if self._is_own and self._is_ready and _has_ended(self._rosout):
            self._rosout = _started("rosrun", "rosout", "rosout", "__name:=rosout")
        return self._is_ready

    def end(self) -> None:
        for process in (self._rosout, self._master):
            if process is not None:
                process.terminate()
                process.wait()

    def _answers(self) -> bool:
        return answers(self._uri, NAME, ANSWER_LIMIT_S)


def _has_ended(process: Optional[subprocess.Popen[bytes]]) -> bool:
    return process is None or process.poll() is not None


def _started(*command: str) -> subprocess.Popen[bytes]:
    # A session of its own: Ctrl-C in a terminal is for the command.
    return subprocess.Popen(command, start_new_session=True)


def run(command: List[str], master: Master, stop: threading.Event) -> int:
    """Run a command beside a master until it ends, or is stopped; return its status."""
    while not master.keep():
        if stop.wait(POLL_S):
            return 0
    child = _started(*command)
    while child.poll() is None and not stop.wait(POLL_S):
        master.keep()
    if stop.is_set():
        child.send_signal(signal.SIGINT)
    return child.wait()


def main() -> int:
    """Run the command of the command line; return its status."""
    command = sys.argv[1:]
    if not command:
        print(__doc__, file=sys.stderr)
        return 2
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop.set())
    master = Master(os.environ["ROS_MASTER_URI"])
    try:
        return run(command, master, stop)
    finally:
        master.end()


if __name__ == "__main__":
    sys.exit(main())
