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

import rosgraph

from gpr20_common.low.clock import Clock
from gpr20_common.terminal_text import enable_line_buffering, say
from gpr20_doctor.low.processes import process_of
from gpr20_launch.low.launched_nodes import LaunchedNodes
from gpr20_launch.mid.watchdog import PERIOD_S, Watchdog

# For each step of a request to a node [s].
ANSWER_LIMIT_S = 2.0

# systemd restarts the whole service if the watchdog says nothing for this long [s].
SERVICE_LIMIT_S = 60.0


def main() -> int:
    """Watch the nodes until roslaunch ends this process, or has ended."""
    enable_line_buffering()
    given = _parser().parse_args(rosgraph.myargv()[1:])
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda _signal, _frame: stop.set())
    roslaunch = os.getppid()
    parent = process_of(roslaunch)
    if parent is None or not parent.is_launch:
        # It may have ended while this process started.
        _say("no roslaunch has started this process; nothing to watch")
        return 1
    prefix = rosgraph.names.get_ros_namespace()
    others = [rosgraph.names.ns_join(prefix, name) for name in given.also]
    word, master = f"configuration:={given.launch}", rosgraph.get_master_uri()
    nodes = LaunchedNodes(roslaunch, word, others, master, ANSWER_LIMIT_S)
    watchdog = Watchdog(nodes, given.limit, Clock(), _say)
    while os.getppid() == roslaunch:
        watchdog.look()
        # The limit is given with each message, not in the unit: a service that waits for a cable or
        # for another machine has none yet.
        notify_systemd(f"WATCHDOG=1\nWATCHDOG_USEC={round(SERVICE_LIMIT_S * 1e6)}")
        if stop.wait(PERIOD_S):
            break
    # Not after an error: systemd guards on, until roslaunch has started the watchdog again.
    notify_systemd("WATCHDOG_USEC=0")
    return 0


def notify_systemd(text: str) -> None:
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
    return parser


def _say(line: str) -> None:
    say(f"watchdog: {line}", file=sys.stderr)
