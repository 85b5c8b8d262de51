"""Joining the ROS graph, or saying why that is not possible."""

from __future__ import annotations

import threading
from typing import Callable

import rosgraph
import rospy

from gpr20_common.low.clock import Clock
from gpr20_user_interface.errors import MasterUnavailableError

POLL_S = 0.2


def join_graph(name: str, wait_s: float, is_cancelled: Callable[[], bool], clock: Clock) -> None:
    """Make this process a ROS node that leaves Ctrl-C to its own handlers.

    `rospy.init_node` alone would wait for a master for ever.

    Args:
        name: Base name of the node; a number makes it one of its own.
        wait_s: How long to wait for the master [s].
        is_cancelled: Asked while waiting; True ends it.
        clock: Measures the waiting.

    Raises:
        MasterUnavailableError: No master answered in time.
    """
    _wait_for_master(wait_s, is_cancelled, clock)
    rospy.init_node(name, anonymous=True, disable_signals=True)


def _wait_for_master(wait_s: float, is_cancelled: Callable[[], bool], clock: Clock) -> None:
    online, given_up = threading.Event(), threading.Event()

    def probe() -> None:
        while not given_up.is_set() and not rosgraph.is_master_online():
            given_up.wait(POLL_S)
        online.set()

    # In a thread, because a connection to an address that swallows packets takes minutes to fail.
    threading.Thread(target=probe, daemon=True).start()
    deadline_s = clock.now_s() + wait_s
    while not clock.wait_s(online, POLL_S):
        if is_cancelled() or clock.now_s() > deadline_s:
            given_up.set()
            waited_s = wait_s + clock.now_s() - deadline_s
            raise MasterUnavailableError(
                f"no ROS master answers at {rosgraph.get_master_uri()} (waited {waited_s:.0f} s); "
                "start `roslaunch gpr20 survey.launch`, or correct ROS_MASTER_URI"
            )
