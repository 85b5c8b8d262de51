"""Asking a node of the graph whether it is there."""

from __future__ import annotations

from typing import Optional

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.limited_rpc import NO_ANSWER, limited_server, value_of
from gpr20_common.low.pid_query import PidQuery
from gpr20_common.message import Message


class NodeProbe:
    """The XML-RPC interface that every ROS node has; not to be shared by threads."""

    def __init__(self, master_uri: str, caller_id: str, node: str, time_limit_s: float) -> None:
        """Connect to nothing yet.

        Args:
            master_uri: Where the master is.
            caller_id: Name of the node that asks.
            node: Full name of the node that is asked.
            time_limit_s: For each answer [s].
        """
        self._caller_id = caller_id
        self._node = node
        self._time_limit_s = time_limit_s
        self._master = limited_server(master_uri, time_limit_s)
        self._query: Optional[PidQuery] = None

    def process(self) -> int:
        """Return the number of the node's process.

        Raises:
            NodeGoneError: It has ended; the message says how that is known.
            NodeSilentError: It does not answer; the message says why.
        """
        is_known = self._query is not None
        try:
            return self._ask()
        except NodeGoneError:
            if not is_known:
                raise
        # The process that took its place has another address.
        return self._ask()

    def _ask(self) -> int:
        try:
            if self._query is None:
                self._query = PidQuery(self._look_up(), self._caller_id, self._time_limit_s)
            # The address is kept: a master that is gone does not make its nodes silent.
            return self._query.ask()
        except NodeGoneError:
            raise
        except NO_ANSWER as error:
            # A master that refuses connections says nothing about the node.
            refused = isinstance(error, ConnectionRefusedError) and self._query is not None
            self._query = None
            raise (NodeGoneError if refused else NodeSilentError)(self._silence(error)) from error

    def _look_up(self) -> str:
        try:
            return str(value_of(self._master.lookupNode(self._caller_id, self._node)))
        except ValueError as error:
            raise NodeGoneError(self._silence(error)) from error

    def _silence(self, error: Exception) -> Message:
        return Message("{node} does not answer", node=self._node, details=error)
