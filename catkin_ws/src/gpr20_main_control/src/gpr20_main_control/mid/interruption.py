"""What ends the waits of a survey before their time."""

from __future__ import annotations

import threading
from typing import Callable

from gpr20_main_control.errors import StopRequested


class Interruption:
    """A stop, or a node that is lost; every wait of a survey looks at it."""

    def __init__(self, stop: threading.Event, check_nodes: Callable[[], None]) -> None:
        """Look at a stop and at the nodes.

        Args:
            stop: Set when the survey shall end.
            check_nodes: Raises NodeLostError if the survey cannot go on with the nodes.
        """
        self.stop = stop
        self._check_nodes = check_nodes

    def check(self) -> None:
        """Return if there is no reason to interrupt.

        Raises:
            StopRequested: The survey was told to stop.
            NodeLostError: A node is gone, or is another than before.
        """
        self.check_stop()
        self._check_nodes()

    def check_stop(self) -> None:
        """Return unless the survey was told to stop.

        Raises:
            StopRequested: It was.
        """
        if self.stop.is_set():
            raise StopRequested("the survey was told to stop")
