"""Bring one survey from the wish to its outcome, by what main_control says."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import List, Optional

from gpr20_common.low.clock import Clock
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState
from gpr20_user_interface.mid.events import (
    Answer,
    ControlState,
    Event,
    Progress,
    Request,
    StopRequested,
)


class Mode(enum.Enum):
    """Which survey is followed."""

    START = "start a new one"
    RESUME = "go on with a paused one"
    ATTACH = "follow the running one"


class OnPause(enum.Enum):
    """What happens when the survey pauses."""

    EXIT = "exit"
    WAIT = "wait"


class ExitStatus(enum.IntEnum):
    """How the survey ended, as the status of the process."""

    FINISHED = 0
    REFUSED = 1
    FAILED = 3
    PAUSED = 4
    STOPPED = 130


@dataclass(frozen=True)
class Outcome:
    """How it ended, in a number and in words."""

    status: ExitStatus
    message: str


@dataclass(frozen=True)
class Limits:
    """How long the follower waits [s]."""

    # For the first word of main_control.
    wait_s: float = 15.0
    # main_control speaks at 2 Hz: ten messages have to be lost.
    silence_s: float = 5.0
    # For a first word about the survey that was started.
    begin_s: float = 10.0
    # For axes to ramp down, a sweep to end and pending traces to be stored.
    stop_s: float = 60.0
    # Between two attempts to have a survey stopped.
    stop_retry_s: float = 2.0


class _Phase(enum.Enum):
    WAITING = "for the first word of main_control"
    REQUESTED = "for the answer to start or resume"
    FOLLOWING = "for the end of the survey"
    ENDED = "for nothing"


_FIRST_REQUEST = {Mode.START: Request.START, Mode.RESUME: Request.RESUME}


class SurveyFollower:
    """Takes events and the passing of time, gives requests and in the end an outcome.

    Attributes:
        outcome: How it ended; None while it has not.
        survey_id: The survey that is followed; empty while it is not known.
    """

    def __init__(self, mode: Mode, on_pause: OnPause, limits: Limits, clock: Clock) -> None:
        self._mode = mode
        self._on_pause = on_pause
        self._limits = limits
        self._clock = clock
        self._phase = _Phase.WAITING
        self.outcome: Optional[Outcome] = None
        # The last word of main_control since something was asked of it; a latched one from
        # before says nothing about this survey.
        self._state: Optional[ControlState] = None
        self.survey_id = ""
        self._seen = False
        self._stop_wanted_s: Optional[float] = None
        self._stop_due_s: Optional[float] = None
        self._stop_message = ""
        now_s = clock.now_s()
        self._began_s = self._heard_s = self._ticked_s = now_s

    def concerns(self, event: Event) -> bool:
        """Return whether a word of main_control is about this survey."""
        if isinstance(event, ControlState) and not self.survey_id:
            return event is self._state and event.code in RUNNING
        if isinstance(event, (ControlState, Progress)):
            return bool(self.survey_id) and event.survey_id == self.survey_id
        return True

    def handle(self, event: Event) -> List[Request]:
        """Take note of an event; return what main_control has to be asked for now."""
        if self._phase is _Phase.ENDED:
            return []
        if isinstance(event, (ControlState, Progress)):
            self._heard_s = self._clock.now_s()
        if isinstance(event, ControlState):
            return self._heard(event)
        if isinstance(event, Answer):
            return self._answered(event)
        if isinstance(event, StopRequested):
            return self._stop_wished()
        return []

    def tick(self) -> List[Request]:
        """Take note of the time; return what main_control has to be asked for now."""
        now_s = self._clock.now_s()
        if now_s - self._ticked_s > self._limits.silence_s / 2:
            # This process itself was held up and has not listened.
            self._heard_s = now_s
        self._ticked_s = now_s
        if self._phase is _Phase.WAITING and now_s - self._began_s > self._limits.wait_s:
            self._end(ExitStatus.REFUSED, _not_there(self._limits.wait_s))
        elif self._phase is _Phase.FOLLOWING and now_s - self._heard_s > self._limits.silence_s:
            self._end(ExitStatus.FAILED, _lost(self._limits.silence_s))
        elif self._stop_wanted_s is not None:
            return self._tick_stop(now_s, now_s - self._stop_wanted_s)
        elif self._phase is _Phase.FOLLOWING and not self._seen:
            self._tick_unseen(now_s - self._began_s)
        return []

    def _tick_unseen(self, waited_s: float) -> None:
        if waited_s > self._limits.begin_s:
            self._end(
                ExitStatus.FAILED,
                f"main_control accepted the survey but said nothing about it for "
                f"{self._limits.begin_s:g} s; look at the topic control_status",
            )

    def _tick_stop(self, now_s: float, waited_s: float) -> List[Request]:
        if waited_s > self._limits.stop_s:
            message = _stop_not_confirmed(self._limits.stop_s, self._stop_message)
            self._end(ExitStatus.FAILED, message)
        elif self._stop_due_s is not None and now_s >= self._stop_due_s:
            return self._ask_stop()
        return []

    def _heard(self, state: ControlState) -> List[Request]:
        if self._phase is _Phase.WAITING:
            return self._first_word(state)
        self._state = state
        if self._phase is _Phase.FOLLOWING:
            self._follow(state)
        return []

    def _first_word(self, state: ControlState) -> List[Request]:
        self._began_s = self._clock.now_s()
        if self._mode is not Mode.ATTACH:
            self._phase = _Phase.REQUESTED
            return [_FIRST_REQUEST[self._mode]]
        if state.code not in RUNNING:
            self._end(
                ExitStatus.REFUSED,
                f"no survey runs: main_control is {state.code.name} ({state.message})",
            )
            return []
        self._begin(state.survey_id, state)
        return []

    def _answered(self, answer: Answer) -> List[Request]:
        if answer.request is Request.STOP:
            self._stop_message = "" if answer.success else answer.message
            if not answer.success:
                self._stop_due_s = self._clock.now_s() + self._limits.stop_retry_s
            return []
        if self._phase is not _Phase.REQUESTED:
            return []
        if not answer.success:
            self._end(*self._refusal(answer))
            return []
        # A resumed survey is known by the next word about it.
        self._begin(answer.survey_id, self._state)
        # A stop that was asked for before the start may have found nothing to stop.
        return self._ask_stop() if self._stopping and self._phase is not _Phase.ENDED else []

    @property
    def _stopping(self) -> bool:
        return self._stop_wanted_s is not None

    def _refusal(self, answer: Answer) -> tuple:
        if self._stopping:
            return ExitStatus.STOPPED, f"the survey was not started: {answer.message}"
        return ExitStatus.REFUSED, answer.message

    def _begin(self, survey_id: str, state: Optional[ControlState]) -> None:
        self._phase = _Phase.FOLLOWING
        self.survey_id = survey_id
        self._state = state
        self._began_s = self._heard_s = self._clock.now_s()
        if state is not None:
            self._follow(state)

    def _follow(self, state: ControlState) -> None:
        if not self.survey_id and state.code in RUNNING | ENDED:
            self.survey_id = state.survey_id
        if state.survey_id != self.survey_id:
            # Before the first word about our survey, this one is from before it began.
            if self._seen:
                self._end(ExitStatus.FAILED, _replaced(self.survey_id, state))
            return
        self._seen = True
        if state.code in ENDED:
            self._end(self._status_of_end(state.code), state.message)
        elif state.code is SurveyState.PAUSED and self._leaves_paused:
            self._end(ExitStatus.PAUSED, state.message)

    @property
    def _leaves_paused(self) -> bool:
        return self._on_pause is OnPause.EXIT and not self._stopping

    def _status_of_end(self, code: SurveyState) -> ExitStatus:
        if code is SurveyState.FINISHED:
            return ExitStatus.FINISHED
        if code is SurveyState.STOPPED and self._stopping:
            return ExitStatus.STOPPED
        return ExitStatus.FAILED

    def _stop_wished(self) -> List[Request]:
        if self._phase is _Phase.WAITING:
            self._end(ExitStatus.STOPPED, "nothing was started")
            return []
        if not self._stopping:
            self._stop_wanted_s = self._clock.now_s()
        return self._ask_stop()

    def _ask_stop(self) -> List[Request]:
        self._stop_due_s = None
        return [Request.STOP]

    def _end(self, status: ExitStatus, message: str) -> None:
        self._phase = _Phase.ENDED
        self.outcome = Outcome(status, message)


def _not_there(wait_s: float) -> str:
    return (
        f"main_control was not heard within {wait_s:g} s; start it with "
        "`roslaunch gpr20 survey.launch`, or, if it runs, check ROS_MASTER_URI and the namespace"
    )


def _lost(silence_s: float) -> str:
    return (
        f"main_control has not been heard for {silence_s:g} s; the robot may still move. Look at "
        "its node; follow the survey again with `rosrun gpr20_user_interface run_survey --attach`"
    )


def _stop_not_confirmed(stop_s: float, refusal: str) -> str:
    reason = f" (last answer to stop_survey: {refusal})" if refusal else ""
    return (
        f"main_control has not said within {stop_s:g} s that the survey has stopped{reason}; "
        "the robot may still run: switch it off if people are near it"
    )


def _replaced(survey_id: str, state: ControlState) -> str:
    return (
        f"main_control does not know survey {survey_id} any more: it is {state.code.name} "
        f"({state.message}); it may have been started anew. What was measured is in the "
        "survey's folder"
    )
