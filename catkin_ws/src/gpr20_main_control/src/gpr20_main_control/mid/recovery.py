"""Waiting, with everything at rest, for a node that is gone."""

from __future__ import annotations

from typing import Callable

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.node_book import NodeBook
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.status_board import StatusBoard
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
        nodes: NodeBook,
        positioner: Positioner,
        board: StatusBoard,
        interruption: Interruption,
        clock: Clock,
        return_limit_s: float,
    ) -> None:
        self._nodes = nodes
        self._positioner = positioner
        self._board = board
        self._interruption = interruption
        self._clock = clock
        self._return_limit_s = return_limit_s
        self._recoveries = 0

    @property
    def nodes_changed(self) -> bool:
        """Whether nodes are missing or others than those with which the survey went on last."""
        return bool(self._nodes.lost())

    def patience(self) -> Callable[[], None]:
        """Return what ends the wait for a storage that may be gone, for a survey that ends.

        It raises NodeLostError once a node is missing and as much time has passed since now as
        a survey waits for one.
        """
        deadline_s = self._clock.now_s() + self._return_limit_s

        def check() -> None:
            if self._nodes.missing() and self._clock.now_s() > deadline_s:
                raise NodeLostError(self._nodes.lost())

        return check

    def begin(self) -> None:
        """Go on with the nodes as they are now.

        Raises:
            NodeLostError: One is missing.
        """
        self._nodes.accept()
        self._nodes.check()

    def note_progress(self) -> None:
        """Note that a trace was stored, or that the operator told the survey to go on."""
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
            StopRequested: The survey was told to stop.
        """
        self._positioner.stop()
        self._say(f"holding: {lost}; the survey goes on by itself when every node is back")
        self._positioner.wait_for_rest(REST_LIMIT_S)
        if self._recoveries >= MOST_RECOVERIES:
            raise NodeLostError(f"{lost}, {MOST_RECOVERIES + 1} times with no trace in between")
        self._recoveries += 1
        deadline_s = self._clock.now_s() + self._return_limit_s
        while self._nodes.missing():
            if self._clock.now_s() > deadline_s:
                raise NodeLostError(
                    f"{lost} and did not come back within {self._return_limit_s:g} s"
                )
            self._clock.wait_s(self._interruption.stop, POLL_S)
            self._interruption.check_stop()

    def _say(self, message: str) -> None:
        if self._board.status.state is SurveyState.CHECKING:
            self._board.say(message)
        else:
            self._board.enter(SurveyState.CHECKING, message)
