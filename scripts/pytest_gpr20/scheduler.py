"""Gives the tests to the workers of pytest-xdist: groups, in the order of the tests."""

from __future__ import annotations

from typing import Any, Callable, Optional

from xdist.scheduler import LoadScopeScheduling


class InOrder(LoadScopeScheduling):
    """Each worker that has little left gets the next group.

    Args:
        config: That of pytest.
        log: That of pytest-xdist.
        group_of: Names the group of a test.
    """

    def __init__(self, config: Any, log: Any, group_of: Callable[[str], str]) -> None:
        # Otherwise the groups would be sorted by their numbers of tests.
        config.option.loadscopereorder = False
        super().__init__(config, log)
        self._group_of = group_of

    def remove_node(self, node: Any) -> Optional[str]:
        """Give back what a dead worker has left, except the test that it died in.

        Returns:
            That test; None if the worker had finished.
        """
        workload = self.assigned_work.pop(node)
        left = [name for unit in workload.values() for name, done in unit.items() if not done]
        if not left:
            return None
        crashed = left[0]
        for scope, unit in reversed(list(workload.items())):
            unit.pop(crashed, None)
            if not all(unit.values()):
                self.workqueue[scope] = unit
                self.workqueue.move_to_end(scope, last=False)
        for other in self.nodes:
            self._reschedule(other)
        return crashed

    def mark_test_pending(self, item: str) -> None:
        """Do nothing: a test that a worker died in has failed and is not repeated."""

    def _split_scope(self, nodeid: str) -> str:
        return self._group_of(nodeid)

    def _reschedule(self, node: Any) -> None:
        # A worker that replaces a dead one gets its share when it has collected the tests.
        if node in self.registered_collections:
            super()._reschedule(node)
