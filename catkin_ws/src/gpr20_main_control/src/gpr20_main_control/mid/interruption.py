"""What ends waits early."""

from __future__ import annotations

import threading

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.errors import ShutDownRequested, StopRequested
from gpr20_main_control.mid.node_liveness import NodeLiveness


class StopInterruption:
    """A stop request; every wait of what can be stopped checks for it.

    Attributes:
        stop: Set when what is in progress must end.
        clock: The clock of every wait.
    """

    def __init__(self, clock: Clock) -> None:
        self.stop = threading.Event()
        self._shutting_down = False
        self.clock = clock

    def shut_down(self) -> None:
        """End every wait, because the main control ends."""
        self._shutting_down = True
        self.stop.set()

    def check(self) -> None:
        """Return if there is no reason to interrupt.

        Raises:
            StopRequested: A stop was requested.
        """
        self.check_stop()

    def check_stop(self) -> None:
        """Return unless a stop was requested.

        Raises:
            ShutDownRequested: The main control ends.
            StopRequested: A stop was requested.
        """
        if self._shutting_down:
            raise ShutDownRequested(Message("the robot is shut down"))
        if self.stop.is_set():
            raise StopRequested(Message("a stop was requested"))

    def wait_s(self, duration_s: float) -> None:
        """Wait [s], unless there is a reason to interrupt.

        Raises:
            StopRequested: A stop was requested.
            NodeLostError: A node does not answer or was restarted.
        """
        self.clock.wait_s(self.stop, duration_s)
        self.check()


class Interruption(StopInterruption):
    """A stop request or a lost node; every wait of a survey checks for them.

    Attributes:
        nodes: The nodes without which a survey cannot continue.
    """

    def __init__(self, nodes: NodeLiveness, clock: Clock) -> None:
        super().__init__(clock)
        self.nodes = nodes

    def check(self) -> None:
        """Return if there is no reason to interrupt.

        Raises:
            StopRequested: A stop of the survey was requested.
            NodeLostError: A node does not answer or was restarted.
        """
        self.check_stop()
        self.nodes.check()
