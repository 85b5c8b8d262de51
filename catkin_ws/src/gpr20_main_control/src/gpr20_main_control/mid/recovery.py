"""Waiting, with everything at rest, for a node that is gone."""

from __future__ import annotations

from typing import Callable

from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.survey_status import SurveyStatus
from gpr20_survey.plan.survey_state import SurveyState

# A survey that loses nodes so often without storing anything meanwhile is left to its operator.
MOST_RECOVERIES = 3
# Axes that slow down from their top speed rest long before this [s].
REST_LIMIT_S = 10.0
POLL_S = 0.05


class Recovery:
    """Decides whether a failure was the loss of a node, and waits until it is back."""

    def __init__(
        self,
        positioner: Positioner,
        status: SurveyStatus,
        interruption: Interruption,
        return_limit_s: float,
    ) -> None:
        self._positioner = positioner
        self._status = status
        self._interruption = interruption
        self._nodes, self._clock = interruption.nodes, interruption.clock
        self._return_limit_s = return_limit_s
        self._recoveries = 0
        self._stored_before = 0

    @property
    def nodes_changed(self) -> bool:
        """Whether nodes are missing or others than those with which the survey continued last."""
        return bool(self._nodes.lost())

    def return_limit_check(self) -> Callable[[], None]:
        """Return what ends the wait for a storage that may be gone, for a survey that ends.

        It raises NodeLostError once a node is missing and as much time has passed since now as
        a survey waits for one.
        """
        deadline_s = self._clock.now_s() + self._return_limit_s

        def check() -> None:
            if self._nodes.missing() and self._clock.now_s() > deadline_s:
                raise NodeLostError(self._nodes.lost())

        return check

    def accept_nodes(self) -> None:
        """Continue with the nodes as they are now.

        Raises:
            NodeLostError: One is missing.
        """
        self._nodes.accept()
        self._nodes.check()

    def note_resumed(self) -> None:
        """Note that the operator resumed the survey: nodes may be lost as often as before."""
        self._recoveries = 0

    def loss_behind(self, error: DeviceError) -> str:
        """Say which nodes were lost if that is behind an error; empty if it is not."""
        if isinstance(error, NodeLostError):
            # It may be back already.
            return str(error)
        # A service fails before its node is known to be gone.
        self._nodes.refresh()
        return self._nodes.lost()

    def wait_for_return(self, lost: str) -> None:
        """Stop all motion and return when all nodes are there.

        Args:
            lost: Which nodes are lost.

        Raises:
            NodeLostError: They stay away, or are lost again and again.
            StopRequested: A stop of the survey was requested.
        """
        self._positioner.stop()
        self._say(f"holding: {lost}; the survey goes on by itself when every node is back")
        self._positioner.wait_for_rest(REST_LIMIT_S)
        self._count_recovery(lost)
        deadline_s = self._clock.now_s() + self._return_limit_s
        while self._nodes.missing():
            if self._clock.now_s() > deadline_s:
                raise NodeLostError(
                    f"{lost} and did not come back within {self._return_limit_s:g} s"
                )
            self._clock.wait_s(self._interruption.stop, POLL_S)
            self._interruption.check_stop()

    def _count_recovery(self, lost: str) -> None:
        stored = self._status.status.visited_points
        if stored != self._stored_before:
            self._recoveries, self._stored_before = 0, stored
        if self._recoveries >= MOST_RECOVERIES:
            raise NodeLostError(f"{lost}, {MOST_RECOVERIES + 1} times with no trace in between")
        self._recoveries += 1

    def _say(self, message: str) -> None:
        if self._status.status.state is SurveyState.CHECKING:
            self._status.set_message(message)
        else:
            self._status.enter(SurveyState.CHECKING, message)
