"""Waiting, with all axes at rest, for a node that was lost."""

from __future__ import annotations

from typing import Optional

from gpr20_common.faults import INTERNAL, PART_RED, PART_SILENT
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.mid.survey.running_survey import RunningSurvey
from gpr20_main_control.mid.waits import Check
from gpr20_survey.plan.survey_state import SurveyState

# A survey that loses nodes more often than this without storing a trace in between is paused.
MOST_RECOVERIES = 3
# Axes that slow down from their top speed come to rest well within this time [s].
REST_LIMIT_S = 10.0
POLL_S = 0.05


class Recovery:
    """Decides whether a lost node caused a failure, and waits until the node is back."""

    def __init__(self, survey: RunningSurvey) -> None:
        self._positioner = survey.positioner
        self._status = survey.status
        self._interruption = survey.interruption
        self._nodes, self._clock = survey.interruption.nodes, survey.clock
        self._return_limit_s = survey.plan.settings.return_limit_s
        self._recoveries = 0
        self._stored_before = 0

    @property
    def nodes_changed(self) -> bool:
        """Whether nodes are missing or were restarted since the survey last continued."""
        return self._nodes.lost() is not None

    def return_limit_check(self) -> Check:
        """Return a check that limits the wait for a storage that may be lost, at a survey's end.

        The check raises NodeLostError if a node is missing and the time limit for lost nodes
        has passed since now.
        """
        deadline_s = self._clock.now_s() + self._return_limit_s

        def check() -> None:
            if self._nodes.missing() and self._clock.now_s() > deadline_s:
                self._nodes.check()

        return check

    def accept_nodes(self) -> None:
        """Continue with the nodes as they are now.

        Raises:
            NodeLostError: One does not answer.
        """
        self._nodes.accept()
        self._nodes.check()

    def note_resumed(self) -> None:
        """Note that the operator resumed the survey: the count of lost nodes begins again."""
        self._recoveries = 0

    def loss_behind(self, error: DeviceError) -> Optional[Message]:
        """Return which nodes were lost if that caused an error; None otherwise."""
        if isinstance(error, NodeLostError):
            # The node may be back already.
            return error.message
        # A service fails before its node is known to be lost.
        self._nodes.refresh()
        return self._nodes.lost()

    def wait_for_return(self, lost: Message) -> None:
        """Stop all motion and return when all nodes answer.

        Args:
            lost: Which nodes are lost.

        Raises:
            NodeLostError: They do not come back, or are lost repeatedly.
            StopRequested: A stop of the survey was requested.
        """
        self._positioner.stop()
        self._show(
            Message(
                "Waiting: {reason}. The survey continues by itself when every part answers.",
                reason=lost,
            ).reporting_only(PART_SILENT.as_warning())
        )
        self._positioner.wait_for_rest(REST_LIMIT_S)
        self._count_recovery(lost)
        deadline_s = self._clock.now_s() + self._return_limit_s
        while self._nodes.missing():
            if self._clock.now_s() > deadline_s:
                raise NodeLostError(
                    Message(
                        "{reason}; no answer within {limit_s:g} s; check its power and its "
                        "cables; if it stays red, switch the robot off and on",
                        reason=lost,
                        limit_s=self._return_limit_s,
                    ).reporting_only(PART_RED)
                )
            self._clock.wait_s(self._interruption.stop, POLL_S)
            self._interruption.check_stop()

    def _count_recovery(self, lost: Message) -> None:
        stored = self._status.status.visited_points
        if stored != self._stored_before:
            self._recoveries, self._stored_before = 0, stored
        if self._recoveries >= MOST_RECOVERIES:
            raise NodeLostError(
                Message(
                    "{reason}; this happened {count} times without a stored trace in between",
                    reason=lost,
                    count=MOST_RECOVERIES + 1,
                ).reporting_only(INTERNAL)
            )
        self._recoveries += 1

    def _show(self, message: Message) -> None:
        if self._status.status.state is SurveyState.CHECKING:
            self._status.set_message(message)
        else:
            self._status.enter(SurveyState.CHECKING, message)
