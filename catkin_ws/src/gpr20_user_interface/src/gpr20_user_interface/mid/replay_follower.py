"""Follow a replay in the terminal client: nothing can be asked of it."""

from __future__ import annotations

from typing import List, Optional

from gpr20_common.message import Message
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface import faults
from gpr20_user_interface.mid.events import ControlState, Progress, Request, StopRequested
from gpr20_user_interface.mid.message_source import SourceGone
from gpr20_user_interface.mid.replay import ReplayMark, ReplayPhase
from gpr20_user_interface.mid.survey_outcome import ExitStatus, Outcome

REFUSAL = Message(
    "A replay of a recorded survey is running here, and no robot. Only --attach can follow it. To "
    "use a robot, end the replay and start the robot."
).with_fault(faults.REPLAY_RUNS)


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
        if isinstance(event, ControlState):
            self._state = event
            self.survey_id = event.survey_id or self.survey_id
        elif isinstance(event, Progress):
            self.survey_id = event.survey_id or self.survey_id
        elif isinstance(event, StopRequested):
            message = Message("The replay is no longer followed.")
            self.outcome = Outcome(ExitStatus.STOPPED, message)
        elif isinstance(event, SourceGone) or _has_ended(event):
            self.outcome = Outcome(ExitStatus.REPLAY, self._end())
        return []

    def tick(self) -> List[Request]:
        """Nothing is due: a replay may pause for any time."""
        return []

    def _end(self) -> Message:
        if self._state is None or self._state.code not in ENDED:
            return Message("The recording does not contain the survey's end.")
        return Message(
            "The recorded survey ended {state}: {message}",
            state=self._state.code.label,
            message=self._state.message,
        )


def _has_ended(event: object) -> bool:
    return isinstance(event, ReplayMark) and event.phase is ReplayPhase.ENDED
