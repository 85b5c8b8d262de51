"""Notices when a node that sends survey messages has ended."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict

import rosgraph
import rospy

from gpr20_common.errors import NodeSilentError
from gpr20_common.high.connection_header import connection_header
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.node_probe import NodeProbe
from gpr20_operator.robot.message_source import SourceGone

PERIOD_S = 1.0
ANSWER_LIMIT_S = 1.0


class ReplayWatch:
    """Asks each node that has sent something, except the main control, whether it is there.

    The main control of a robot is watched by its messages, which never pause as a replay does.

    Args:
        main_control: Full name of the robot's main control.
        listener: Called with each event.
    """

    def __init__(self, main_control: str, listener: Callable[[SourceGone], None]) -> None:
        self._main_control = main_control
        self._listener = listener
        self._lock = threading.Lock()
        self._probes: Dict[str, NodeProbe] = {}
        self._periodic = Periodic(PERIOD_S, self._check)

    def note(self, message: Any) -> None:
        """Note the sender of a message."""
        source = connection_header(message)["callerid"]
        if source == self._main_control:
            return
        with self._lock:
            if source not in self._probes:
                self._probes[source] = NodeProbe(
                    rosgraph.get_master_uri(), rospy.get_name(), source, ANSWER_LIMIT_S
                )

    def close(self) -> None:
        """Watch no more."""
        self._periodic.stop()

    def _check(self) -> None:
        with self._lock:
            probes = dict(self._probes)
        for source, probe in probes.items():
            try:
                probe.process()
            except NodeSilentError:
                with self._lock:
                    del self._probes[source]
                self._listener(SourceGone(source))
