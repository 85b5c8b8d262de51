"""Whether the link to the main control is down."""

from __future__ import annotations

from typing import Callable

import rosgraph
import rospy

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.node_probe import NodeProbe
from gpr20_operator.robot.events import LinkState

PERIOD_S = 1.0
# The first probe that remains unanswered ends before a follower takes the silence for an end.
ANSWER_LIMIT_S = 3.0


class LinkWatch:
    """Asks the main control for its process, and reports when the link breaks and is back."""

    def __init__(self, listener: Callable[[LinkState], None]) -> None:
        """Begin to ask.

        Args:
            listener: Called with each change, from a thread of its own.
        """
        node = rospy.resolve_name("main_control")
        master_uri, own_name = rosgraph.get_master_uri(), rospy.get_name()
        self._probe = NodeProbe(master_uri, own_name, node, ANSWER_LIMIT_S)
        self._listener = listener
        self._down = False
        self._gone = False
        self._periodic = Periodic(PERIOD_S, self._check)

    def close(self) -> None:
        """Stop asking."""
        self._periodic.stop()

    def _check(self) -> None:
        try:
            self._probe.process()
            self._gone = False
            self._note(False)
        except NodeGoneError:
            self._gone = True
            self._note(False)
        except NodeSilentError:
            # After a certain end, the silence of the master says nothing about the link.
            self._note(not self._gone)

    def _note(self, down: bool) -> None:
        if down != self._down:
            self._down = down
            self._listener(LinkState(down))
