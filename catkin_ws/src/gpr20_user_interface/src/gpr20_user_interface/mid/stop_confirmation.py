"""Whether a STOP is confirmed; until then the operator may have to switch off the motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthLevel
from gpr20_survey.plan.survey_state import ENDED, SurveyState
from gpr20_user_interface.mid.events import Answer, Request
from gpr20_user_interface.mid.fault_messages import axis_may_move
from gpr20_user_interface.mid.survey_model import Snapshot

# A main control that works answers sooner [s].
ANSWER_S = 0.2
AXIS_NODES = ("x_axis/axis_driver", "y_axis/axis_driver", "z_axis/axis_driver")


@dataclass(frozen=True)
class StopWarning:
    """What is shown over everything until a STOP is confirmed.

    Attributes:
        title: What to do.
        text: What is known about the stop.
    """

    title: Message
    text: Message


class StopConfirmation:
    """Follows a STOP from the press to its confirmation. Belongs to one thread."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._pressed_s: Optional[float] = None
        self._state_at_press: Optional[SurveyState] = None
        # Why the stop is doubtful although nothing has failed yet.
        self._doubt: Optional[Message] = None
        # Whether a STOP that the main control has accepted may not reach the axes.
        self._cut_off = False
        self._answer: Optional[Message] = None

    def press(self, snapshot: Snapshot) -> None:
        """Note that STOP was pressed."""
        self._pressed_s = self._clock.now_s()
        self._state_at_press = None if snapshot.state is None else snapshot.state.code
        axes_silent = _axes_are_silent(snapshot)
        self._cut_off = axes_silent or not snapshot.master_alive
        self._doubt = _doubt(snapshot, axes_silent)
        self._answer = None

    def on_event(self, event: object) -> None:
        """Take an event."""
        if not isinstance(event, Answer) or event.request is not Request.STOP:
            return
        if event.success and self._cut_off:
            return  # only the end of the survey, or the answers of the axes, confirm it
        self._answer = event.message
        if event.contact:
            self.close()

    def close(self) -> None:
        """Note that the operator has read the warning, or that it is over."""
        self._pressed_s = None

    def warning(self, snapshot: Snapshot) -> Optional[StopWarning]:
        """Return what is shown now; None: STOP was not pressed, or is confirmed."""
        if self._pressed_s is None:
            return None
        if self._is_confirmed_by(snapshot):
            self.close()
            return None
        late = self._clock.now_s() - self._pressed_s >= ANSWER_S
        if self._doubt is None and not late:
            return None
        why = self._answer or self._doubt or Message("The robot has not answered yet.")
        return StopWarning(Message("SWITCH OFF THE MOTORS' POWER"), why)

    def _is_confirmed_by(self, snapshot: Snapshot) -> bool:
        state = snapshot.state
        if state is None or not snapshot.control_alive or state.code is self._state_at_press:
            return False
        if state.code in ENDED:
            return not axis_may_move(state)
        return state.code is SurveyState.STOPPING and not self._cut_off


def _axes_are_silent(snapshot: Snapshot) -> bool:
    reporting = [one.name for one in snapshot.health.nodes if one.level is not HealthLevel.STALE]
    # If no node reports, the reports are missing and not the axes.
    return bool(reporting) and not any(name in reporting for name in AXIS_NODES)


def _doubt(snapshot: Snapshot, axes_silent: bool) -> Optional[Message]:
    if not snapshot.master_alive:
        return Message("The ROS master does not answer: STOP is not confirmed.")
    if not snapshot.control_alive:
        return Message("The main control does not answer: STOP is not confirmed.")
    if axes_silent:
        return Message("No axis answers: STOP is not confirmed.")
    return None
