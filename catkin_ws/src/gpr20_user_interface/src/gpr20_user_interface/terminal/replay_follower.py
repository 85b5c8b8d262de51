"""Follow a replay in the terminal client: nothing can be asked of it."""

from __future__ import annotations

from typing import List, Optional

from gpr20_common.message import Message
from gpr20_operator.robot.events import ControlState, Request, StopRequested
from gpr20_operator.robot.replay_model import ReplayModel
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface.terminal.follower import ExitStatus, Outcome


class ReplayFollower:
    """Takes events and gives in the end an outcome.

    Attributes:
        outcome: How it ended; None while it has not.
    """

    def __init__(self) -> None:
        self.outcome: Optional[Outcome] = None
        self._model = ReplayModel()

    @property
    def survey_id(self) -> str:
        """The recorded survey; empty while it is not known."""
        return self._model.survey_id

    def concerns(self, event: object) -> bool:
        """Return whether an event is to be shown."""
        return not isinstance(event, StopRequested)

    def handle(self, event: object) -> List[Request]:
        """Take an event; there is never a request to send."""
        self._model.handle(event)
        shown = self._model.snapshot()
        if isinstance(event, StopRequested):
            message = Message("The replay is no longer followed.")
            self.outcome = Outcome(ExitStatus.STOPPED, message)
        elif shown.replay is not None and shown.replay.ended:
            self.outcome = Outcome(ExitStatus.REPLAY, _end(shown.state))
        return []

    def tick(self) -> List[Request]:
        """Nothing is due: a replay may pause for any time."""
        return []


def _end(state: Optional[ControlState]) -> Message:
    if state is None or state.code not in ENDED:
        return Message("The recording does not contain the survey's end.")
    return Message(
        "The recorded survey ended {state}: {message}",
        state=state.code.label,
        message=state.message,
    )
