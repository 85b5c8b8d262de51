"""watchdog: what the launch files run beside the nodes of a robot.

It is no node: it must work without the master, and needs nothing of the graph.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import socket
import sys
import threading
from typing import Dict, Mapping, Tuple

import rosgraph

from gpr20_common.low.clock import Clock
from gpr20_common.terminal_text import enable_line_buffering, say
from gpr20_launch.low import sibling_nodes
from gpr20_launch.low.node_answer import Answer, NodeAnswer
from gpr20_launch.low.process_info import process_info
from gpr20_launch.mid.watchdog import ANSWER_LIMIT_S, PERIOD_S, Watchdog

# systemd restarts the whole service if the watchdog says nothing for this long [s].
SERVICE_LIMIT_S = 60.0


class LaunchedNodes:
    """The nodes beside this process; a `Nodes`."""

    def __init__(self, siblings: sibling_nodes.SiblingNodes) -> None:
        self._siblings = siblings
        self._answers: Dict[Tuple[int, str], NodeAnswer] = {}

    def find(self) -> Mapping[int, str]:
        found = self._siblings.find()
        self._answers = {key: one for key, one in self._answers.items() if key in found.items()}
        return found

    def ask(self, number: int, name: str) -> Answer:
        if (number, name) not in self._answers:
            uri = rosgraph.get_master_uri()
            self._answers[number, name] = NodeAnswer(uri, name, number, ANSWER_LIMIT_S)
        return self._answers[number, name].ask()

    def is_working(self, number: int) -> bool:
        return sibling_nodes.is_working(number)

    def is_traced(self, number: int) -> bool:
        return sibling_nodes.is_traced(number)

    def kill(self, number: int, name: str) -> None:
        self._siblings.kill(number, name)


def main() -> int:
    """Watch the nodes until roslaunch ends this process, or has ended."""
    enable_line_buffering()
    given = _parser().parse_args(rosgraph.myargv()[1:])
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda _signal, _frame: stop.set())
    roslaunch = os.getppid()
    parent = process_info(roslaunch)
    if parent is None or not parent.is_roslaunch:
        # It may have ended while this process started.
        _say("no roslaunch has started this process; nothing to watch")
        return 1
    prefix = rosgraph.names.get_ros_namespace()
    others, spared = (
        [rosgraph.names.ns_join(prefix, name) for name in names]
        for names in (given.also, given.spared)
    )
    siblings = sibling_nodes.SiblingNodes(roslaunch, f"configuration:={given.launch}", others)
    watchdog = Watchdog(LaunchedNodes(siblings), given.limit, Clock(), _say, spared)
    while os.getppid() == roslaunch:
        watchdog.look()
        if watchdog.complete:
            # The limit is given with each message, not in the unit: a service that waits for a
            # cable or for another machine has none yet.
            tell_systemd(f"WATCHDOG=1\nWATCHDOG_USEC={round(SERVICE_LIMIT_S * 1e6)}")
        if stop.wait(PERIOD_S):
            break
    # Not after an error: systemd guards on, until roslaunch has started the watchdog again.
    tell_systemd("WATCHDOG_USEC=0")
    return 0


def tell_systemd(text: str) -> None:
    """Say something to the systemd that runs this process as a part of a service (sd_notify(3))."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    # A leading @ stands for the zero byte of an abstract address (unix(7)).
    address = "\0" + address[1:] if address.startswith("@") else address
    if address:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.setblocking(False)
            # It is busy, and the next message says the same, or nobody listens any more.
            with contextlib.suppress(OSError):
                sender.sendto(text.encode(), address)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        description="Restart nodes of this launch that do not answer; used by the launch files."
    )
    parser.add_argument("--launch", required=True, help="name of the launch's configuration")
    parser.add_argument("--limit", type=float, required=True, help="longest silence of a node [s]")
    parser.add_argument("--also", nargs="*", default=[], help="nodes without a configuration")
    parser.add_argument("--spared", nargs="*", default=[], help="nodes that may stay away")
    return parser


def _say(line: str) -> None:
    say(f"watchdog: {line}", file=sys.stderr)
