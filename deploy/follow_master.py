"""Run a command on a ROS master, and again when another master has taken its place.

follow_master.py COMMAND ...

The robot's nodes outlive the master when the PC restarts, but the new master does not know them.
SIGINT and SIGTERM end the command with SIGINT, as Ctrl-C does.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from typing import Callable, List, Optional

from gpr20_common.low.links import NO_ANSWER, limited_server, value_of

POLL_S = 1.0
ANSWER_LIMIT_S = 3.0
# roslaunch kills a node that does not end within 17 s.
END_LIMIT_S = 60.0
NAME = "/gpr20_follow_master"
EXIT_NOT_ENDED = 1


def read_run_id(uri: str) -> Optional[str]:
    """Return the id of the run of a master; None while none answers.

    roslaunch sets it when its master has started, and no two masters have the same.
    """
    try:
        return str(value_of(limited_server(uri, ANSWER_LIMIT_S).getParam(NAME, "/run_id")))
    except NO_ANSWER:
        return None


class Follower:
    """Runs a command once for each master.

    Args:
        command: The command and its arguments.
        run_id: Returns the id of the run of the master, None while none answers.
        say: Prints a sentence.
    """

    def __init__(
        self, command: List[str], run_id: Callable[[], Optional[str]], say: Callable[[str], None]
    ) -> None:
        self._command = command
        self._run_id = run_id
        self._say = say
        self._stop = threading.Event()

    def stop(self) -> None:
        """End the command and `follow`."""
        self._stop.set()

    def _wait_for_master(self) -> Optional[str]:
        """Return the id of the master's run as soon as there is one; None when stopped."""
        run = self._run_id()
        if run is None:
            self._say("waiting for the ROS master; start the server")
        while run is None and not self._stop.wait(POLL_S):
            run = self._run_id()
        return run

    def follow(self) -> int:
        """Run the command until it ends by itself or `stop` is called; return its status."""
        while True:
            run = self._wait_for_master()
            if run is None or self._stop.is_set():
                return 0
            # A session of its own: Ctrl-C in a terminal reaches it once, through this process.
            child = subprocess.Popen(self._command, start_new_session=True)
            status = self._watch(child, run)
            if status is not None:
                return status

    def _watch(self, child: subprocess.Popen[bytes], run: str) -> Optional[int]:
        """Return the status of the command; None if it ended for a new master."""
        while True:
            stopped = self._stop.wait(POLL_S)
            status = child.poll()
            if status is not None:
                return status
            # A link that is down for a while is no new master.
            replaced = not stopped and self._run_id() not in (None, run)
            if stopped or replaced:
                break
        if replaced:
            self._say("the ROS master was restarted; starting again for the new one")
        child.send_signal(signal.SIGINT)
        try:
            status = child.wait(END_LIMIT_S)
        except subprocess.TimeoutExpired:
            self._say(f"{self._command[0]} has not ended within {END_LIMIT_S:g} s")
            os.killpg(child.pid, signal.SIGKILL)
            child.wait()
            return EXIT_NOT_ENDED
        return None if replaced else status


def main() -> int:
    """Follow the master of ROS_MASTER_URI with the command of the command line."""
    command = sys.argv[1:]
    if not command:
        print(__doc__, file=sys.stderr)
        return 2
    uri = os.environ["ROS_MASTER_URI"]
    follower = Follower(command, lambda: read_run_id(uri), lambda text: print(text, flush=True))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: follower.stop())
    return follower.follow()


if __name__ == "__main__":
    sys.exit(main())
