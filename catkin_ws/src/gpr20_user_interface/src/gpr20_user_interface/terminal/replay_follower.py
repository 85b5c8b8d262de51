"""Follow a replay in the terminal client: nothing can be asked of it."""

from __future__ import annotations

from functools import singledispatchmethod
from typing import List, Optional

from gpr20_common.message import Message
from gpr20_operator.robot.events import ControlState, Progress, Request, StopRequested
from gpr20_operator.robot.replay import PlayerLink, ReplayMark, ReplayPhase
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface.terminal.follower import ExitStatus, Outcome


class ReplayFollower:
    """Takes events and gives in the end an outcome.

    Attributes:
        outcome: How it ended; None while it has not.
        survey_id: The recorded survey; empty while it is not known.
    """

    def __init__(self) -> None:
        self.outcome: Optional[Outcome] = None
        self.survey_id = ""
        self._state: Optional[ControlState] = None

    def concerns(self, event: object) -> bool:
        """Return whether an event is to be shown."""
        return not isinstance(event, StopRequested)

    def handle(self, event: object) -> List[Request]:
        """Take an event; there is never a request to send."""
        self._take(event)
        return []

    def tick(self) -> List[Request]:
        """Nothing is due: a replay may pause for any time."""
        return []

    @singledispatchmethod
    def _take(self, _event: object) -> None:
        """Take no notice of other events."""

    @_take.register
    def _(self, state: ControlState) -> None:
        self._state = state
        self.survey_id = state.survey_id or self.survey_id

    @_take.register
    def _(self, progress: Progress) -> None:
        self.survey_id = progress.survey_id or self.survey_id

    @_take.register
    def _(self, _request: StopRequested) -> None:
        message = Message("The replay is no longer followed.")
        self.outcome = Outcome(ExitStatus.STOPPED, message)

    @_take.register
    def _(self, link: PlayerLink) -> None:
        if not link.connected:
            self._end()

    @_take.register
    def _(self, mark: ReplayMark) -> None:
        if mark.phase is ReplayPhase.ENDED:
            self._end()

    def _end(self) -> None:
        message = Message("The recording does not contain the survey's end.")
        if self._state is not None and self._state.code in ENDED:
            message = Message(
                "The recorded survey ended {state}: {message}",
                state=self._state.code.label,
                message=self._state.message,
            )
        self.outcome = Outcome(ExitStatus.REPLAY, message)
