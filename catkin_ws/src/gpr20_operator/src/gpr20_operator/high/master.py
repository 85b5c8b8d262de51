"""Joining the ROS graph."""

from __future__ import annotations

import threading
from typing import Callable

import rosgraph
import rospy

from gpr20_common.faults import ASKED_FOR
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import enable_line_buffering
from gpr20_operator.errors import MasterUnavailableError

POLL_S = 0.2
# To join a master that answers.
JOIN_LIMIT_S = 15.0


def join_graph(name: str, wait_s: float, is_cancelled: Callable[[], bool], clock: Clock) -> None:
    """Make this process a ROS node that leaves Ctrl-C to its own handlers.

    `rospy.init_node` alone would wait for a master without a limit.

    Args:
        name: Base name of the node; a number makes it one of its own.
        wait_s: How long to wait for the master [s].
        is_cancelled: Checked while waiting; True ends it.
        clock: Measures the waiting.

    Raises:
        MasterUnavailableError: No master answered in time, it died while it was joined, or it
            was cancelled.
    """
    enable_line_buffering()
    online, joined, given_up = threading.Event(), threading.Event(), threading.Event()

    def join() -> None:
        while not given_up.is_set() and not rosgraph.is_master_online():
            given_up.wait(POLL_S)
        online.set()
        if not given_up.is_set():
            rospy.init_node(name, anonymous=True, disable_rostime=True, disable_signals=True)
            joined.set()

    # In a thread, because a connection to an address that swallows packets takes minutes to fail.
    threading.Thread(target=join, daemon=True).start()
    begin_s = clock.now_s()
    for event, limit_s in ((online, wait_s), (joined, JOIN_LIMIT_S)):
        if not _happens(event, limit_s, is_cancelled, clock):
            given_up.set()
            if is_cancelled():
                raise MasterUnavailableError(
                    Message("stopped before contact with the robot; nothing was started"),
                    fault=ASKED_FOR,
                )
            waited_s = clock.now_s() - begin_s
            raise MasterUnavailableError(
                Message(
                    "no ROS master answers at {address} within {waited_s:.0f} s; start `roslaunch "
                    "gpr20 survey.launch`, or correct ROS_MASTER_URI",
                    address=rosgraph.get_master_uri(),
                    waited_s=waited_s,
                )
            )


def _happens(
    event: threading.Event, limit_s: float, is_cancelled: Callable[[], bool], clock: Clock
) -> bool:
    """Wait for an event; return whether it came within the limit."""
    deadline_s = clock.now_s() + limit_s
    while not clock.wait_s(event, POLL_S):
        if is_cancelled() or clock.now_s() > deadline_s:
            return False
    return True
