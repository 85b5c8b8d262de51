"""Follow one survey from the request to its end, by the status of the main control."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import List, Optional

from gpr20_common.faults import MAY_MOVE, NOT_RUNNING, PART_LOST
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    LinkState,
    Progress,
    Request,
    StopRequested,
)
from gpr20_operator.robot.senders import SenderIgnored
from gpr20_survey.faults import NONE_OPEN
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

REPLAY = Message(
    "A replay of a recorded survey is running here, and no robot. Only --attach can follow it. To "
    "use a robot, end the replay and start the robot."
).with_fault(faults.REPLAY)


class ExitStatus(enum.IntEnum):
    """How the survey ended, as the status of the process."""

    FINISHED = 0
    REFUSED = 1
    FAILED = 3
    PAUSED = 4
    # What was followed was a replay: nothing was measured.
    REPLAY = 5
    STOPPED = 130


@dataclass(frozen=True)
class Outcome:
    """How it ended: a status for the shell and a sentence.

    Attributes:
        other_analyzer: Identity of another analyzer with which the survey can be resumed; empty
            if there is nothing to accept.
    """

    status: ExitStatus
    message: Message
    other_analyzer: str = ""


class Mode(enum.Enum):
    """Which survey is followed."""

    START = "start a new one"
    RESUME = "resume a paused one"
    ATTACH = "follow the running one"


class OnPause(enum.Enum):
    """What happens when the survey pauses."""

    EXIT = "exit"
    WAIT = "wait"


@dataclass(frozen=True)
class Limits:
    """How long the follower waits [s]."""

    # For the first status of the main control.
    wait_s: float = 15.0
    # The main control publishes at 2 Hz: ten messages have to be lost.
    silence_s: float = 5.0
    # While the link is down; the survey itself waits for 300 s by default and then pauses.
    link_down_s: float = 600.0
    # For topics to be connected again when the link is back.
    link_back_s: float = 20.0
    # For the first status of the survey that was started.
    begin_s: float = 10.0
    # For axes to ramp down, a sweep to end and pending traces to be stored.
    stop_s: float = 60.0
    # Between two attempts to have a survey stopped.
    stop_retry_s: float = 2.0


class _Phase(enum.Enum):
    WAITING = "for the first status of the main control"
    REQUESTED = "for the answer to start or resume"
    FOLLOWING = "for the end of the survey"
    ENDED = "for nothing"


_FIRST_REQUEST = {Mode.START: Request.START, Mode.RESUME: Request.RESUME}


class SurveyFollower:
    """Takes events and the passing of time, gives requests and in the end an outcome."""

    def __init__(self, mode: Mode, on_pause: OnPause, limits: Limits, clock: Clock) -> None:
        self._mode = mode
        self._on_pause = on_pause
        self._limits = limits
        self._clock = clock
        self._phase = _Phase.WAITING
        self.outcome: Optional[Outcome] = None
        # The last status since the request; a latched one from before it is about another
        # survey.
        self._state: Optional[ControlState] = None
        self.survey_id = ""
        self._seen = False
        self._ignored = False
        self._awaits_begin = False
        self._stop_wanted_s: Optional[float] = None
        self._stop_due_s: Optional[float] = None
        self._stop_refusal: Optional[Message] = None
        self._link_down = False
        now_s = clock.now_s()
        self._began_s = self._received_s = self._ticked_s = now_s

    def concerns(self, event: object) -> bool:
        """Return whether an event is about this survey."""
        if isinstance(event, ControlState) and not self.survey_id:
            return event is self._state and event.code in RUNNING
        if isinstance(event, (ControlState, Progress)):
            return bool(self.survey_id) and event.survey_id == self.survey_id
        return True

    def handle(self, event: object) -> List[Request]:
        """Take an event; return the requests to send to the main control now."""
        if self._phase is _Phase.ENDED:
            return []
        if isinstance(event, (ControlState, Progress)):
            self._received_s = self._clock.now_s()
        if isinstance(event, ControlState):
            return self._take_state(event)
        if isinstance(event, Answer):
            return self._answered(event)
        if isinstance(event, StopRequested):
            return self._request_stop()
        if isinstance(event, LinkState):
            self._take_link(event)
        if isinstance(event, SenderIgnored):
            self._ignored = True
        return []

    def ask_again(self) -> List[Request]:
        """Return the request that was refused, to be sent again; its answer is awaited."""
        self._phase = _Phase.REQUESTED
        self.outcome = None
        # What the refused request led to may still be reported.
        self._state = None
        self._awaits_begin = True
        return [_FIRST_REQUEST[self._mode]]

    def _take_link(self, link: LinkState) -> None:
        if self._link_down and not link.down:
            wait_s = self._limits.link_back_s - self._limits.silence_s
            self._received_s = max(self._received_s, self._clock.now_s() + wait_s)
        self._link_down = link.down

    def tick(self) -> List[Request]:
        """Check the time limits; return the requests to send to the main control now."""
        now_s = self._clock.now_s()
        if now_s - self._ticked_s > self._limits.silence_s / 2:
            # This process itself was suspended and has received nothing.
            self._received_s = now_s
        self._ticked_s = now_s
        if self._phase is _Phase.WAITING and now_s - self._began_s > self._limits.wait_s:
            self._end(ExitStatus.REFUSED, REPLAY if self._ignored else self._not_there())
        elif self._phase is _Phase.FOLLOWING and now_s - self._received_s > self._silence_limit_s:
            self._end(ExitStatus.FAILED, self._lost())
        elif self._stop_wanted_s is not None:
            return self._tick_stop(now_s, now_s - self._stop_wanted_s)
        elif self._phase is _Phase.FOLLOWING and not self._seen:
            self._tick_unseen(now_s - self._began_s)
        return []

    @property
    def _silence_limit_s(self) -> float:
        return self._limits.link_down_s if self._link_down else self._limits.silence_s

    def _tick_unseen(self, waited_s: float) -> None:
        if waited_s > self._limits.begin_s:
            self._end(
                ExitStatus.FAILED,
                Message(
                    "The main control accepted the survey but has not reported on it for "
                    "{limit_s:g} s. Check that it is running.",
                    limit_s=self._limits.begin_s,
                    details="topic control_status",
                ).with_fault(PART_LOST),
            )

    def _tick_stop(self, now_s: float, waited_s: float) -> List[Request]:
        # A survey that is not stopped continues when the link is back.
        if waited_s > self._limits.stop_s and not self._link_down:
            self._end(ExitStatus.FAILED, self._stop_not_confirmed())
        elif self._stop_due_s is not None and now_s >= self._stop_due_s:
            return self._ask_stop()
        return []

    def _take_state(self, state: ControlState) -> List[Request]:
        if self._phase is _Phase.WAITING:
            return self._take_first_state(state)
        if self._awaits_begin and (state.code not in RUNNING or state.code is SurveyState.PAUSED):
            return []
        self._awaits_begin = False
        self._state = state
        if self._phase is _Phase.FOLLOWING:
            self._follow(state)
        return []

    def _take_first_state(self, state: ControlState) -> List[Request]:
        self._began_s = self._clock.now_s()
        if self._mode is not Mode.ATTACH:
            self._phase = _Phase.REQUESTED
            return [_FIRST_REQUEST[self._mode]]
        if state.code not in RUNNING:
            self._end(
                ExitStatus.REFUSED,
                Message(
                    "No survey is running. The main control is {state}: {message}",
                    state=state.code.label,
                    message=state.message,
                ).reporting_only(NONE_OPEN),
            )
            return []
        self._begin(state.survey_id, state)
        return []

    def _answered(self, answer: Answer) -> List[Request]:
        if answer.request is Request.STOP:
            self._stop_refusal = None if answer.success else answer.message
            if not answer.success:
                self._stop_due_s = self._clock.now_s() + self._limits.stop_retry_s
            return []
        if self._phase is not _Phase.REQUESTED:
            return []
        if not answer.success:
            self._phase = _Phase.ENDED
            self.outcome = self._refusal(answer)
            return []
        # The id of a resumed survey comes with its next status.
        self._begin(answer.survey_id, self._state)
        # A stop that was asked for before the start may have found nothing to stop.
        return self._ask_stop() if self._stopping and self._phase is not _Phase.ENDED else []

    @property
    def _stopping(self) -> bool:
        return self._stop_wanted_s is not None

    def _refusal(self, answer: Answer) -> Outcome:
        if self._stopping:
            message = Message("The survey was not started: {reason}", reason=answer.message)
            return Outcome(ExitStatus.STOPPED, message)
        return Outcome(ExitStatus.REFUSED, answer.message, answer.other_analyzer)

    def _begin(self, survey_id: str, state: Optional[ControlState]) -> None:
        self._phase = _Phase.FOLLOWING
        self.survey_id = survey_id
        self._state = state
        self._began_s = self._received_s = self._clock.now_s()
        if state is not None:
            self._follow(state)

    def _follow(self, state: ControlState) -> None:
        if not self.survey_id and state.code in RUNNING | ENDED:
            self.survey_id = state.survey_id
        if state.survey_id != self.survey_id:
            # Before the first status of our survey, this one is from before it began.
            if self._seen:
                self._end(ExitStatus.FAILED, self._replaced(state))
            return
        self._seen = True
        if state.shown in ENDED:
            said = state.message if state.code is state.shown else state.title
            self._end(self._status_of_end(state.shown), said)
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

    def _request_stop(self) -> List[Request]:
        if self._phase is _Phase.WAITING:
            self._end(ExitStatus.STOPPED, Message("Nothing was started."))
            return []
        if not self._stopping:
            self._stop_wanted_s = self._clock.now_s()
        return self._ask_stop()

    def _ask_stop(self) -> List[Request]:
        self._stop_due_s = None
        return [Request.STOP]

    def _end(self, status: ExitStatus, message: Message) -> None:
        self._phase = _Phase.ENDED
        self.outcome = Outcome(status, message)

    def _not_there(self) -> Message:
        return Message(
            "No contact with the main control within {limit_s:g} s. Start it with `roslaunch gpr20 "
            "survey.launch`. If it is running, check ROS_MASTER_URI and the namespace.",
            limit_s=self._limits.wait_s,
        ).with_fault(NOT_RUNNING)

    def _lost(self) -> Message:
        return Message(
            "No contact with the main control for {limit_s:g} s. The robot may still move. Check "
            "that the main control is running, then follow the survey again with `rosrun "
            "gpr20_user_interface run_survey --attach`.",
            limit_s=self._silence_limit_s,
        ).with_fault(PART_LOST)

    def _stop_not_confirmed(self) -> Message:
        limit_s, refusal = self._limits.stop_s, self._stop_refusal
        if refusal is None:
            return Message(
                "The main control did not confirm within {limit_s:g} s that the survey has "
                "stopped. The robot may still move: switch it off if people are near it.",
                limit_s=limit_s,
            ).with_fault(MAY_MOVE)
        return Message(
            "The main control did not confirm within {limit_s:g} s that the survey has stopped; "
            "its last answer to the stop request: {answer}. The robot may still move: switch it "
            "off if people are near it.",
            limit_s=limit_s,
            answer=refusal,
        ).reporting_only(MAY_MOVE)

    def _replaced(self, state: ControlState) -> Message:
        return Message(
            "The main control no longer knows survey {survey}; it may have been restarted. The "
            "traces measured so far are in the survey's folder. The main control is {state}: "
            "{message}",
            survey=self.survey_id,
            state=state.code.label,
            message=state.message,
        ).reporting_only(PART_LOST)
