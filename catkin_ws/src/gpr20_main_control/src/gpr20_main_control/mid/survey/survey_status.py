"""The status of the main control, in one place, and the coverage of the survey that runs."""

from __future__ import annotations

import re
import threading
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Callable, Dict, FrozenSet, Iterable, List, Optional, Tuple

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import RequestRefusedError
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.plan.survey_state import ENDED, SampleState, SurveyState, Verdict, verdict

if TYPE_CHECKING:  # the plan imports what shows itself by this status
    from gpr20_main_control.mid.survey.survey_plan import SurveyPlan

RUN = re.compile(rb"(.)\1*", re.DOTALL)
NO_PARAMETERS = Message("Set the parameters of a survey.")
_S = SurveyState
TRANSITIONS: Dict[SurveyState, FrozenSet[SurveyState]] = {
    # From rest to CHECKING without new parameters: a survey is resumed from its folder.
    _S.IDLE: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.CONFIGURED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    # To itself: another node was lost. To FINISHED: when everything was stored already.
    _S.CHECKING: frozenset(
        [_S.CHECKING, _S.HOMING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]
    ),
    _S.HOMING: frozenset([_S.CHECKING, _S.SURVEYING, _S.PAUSED, _S.STOPPING, _S.FAILED]),
    # Back to CHECKING: a node was lost; the survey continues by itself when it is back.
    _S.SURVEYING: frozenset(
        [_S.CHECKING, _S.PAUSING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]
    ),
    _S.PAUSING: frozenset([_S.CHECKING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]),
    _S.PAUSED: frozenset([_S.CHECKING, _S.STOPPING, _S.FAILED]),
    # To FINISHED: the robot was shut down when everything was stored already.
    _S.STOPPING: frozenset([_S.STOPPED, _S.FINISHED, _S.FAILED]),
    _S.FINISHED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.STOPPED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.FAILED: frozenset([_S.CONFIGURED, _S.CHECKING]),
}


class Coverage:
    """The state of every planned sample, which counts as measured once it is stored durably."""

    def __init__(
        self,
        planned: int,
        stored: Iterable[int] = (),
        on_change: Callable[[Coverage], None] = lambda _coverage: None,
    ) -> None:
        """Begin with what is stored; `on_change` is called with this object at every change."""
        # One byte per sample: announcing a change must not take longer in a survey of many
        # thousands.
        self._states = bytearray(planned)
        self._reasons: Dict[int, Message] = {}
        self._on_change = on_change
        for index in stored:
            self._states[index] = SampleState.MEASURED

    @property
    def planned(self) -> int:
        return len(self._states)

    @property
    def states(self) -> List[SampleState]:
        """The state of each planned sample, in the order of the plan."""
        return [SampleState(state) for state in self._states]

    def runs(self) -> List[Tuple[int, SampleState]]:
        """Return where in the plan each run of samples of one state begins, and that state."""
        found = RUN.finditer(bytes(self._states))
        return [(run.start(), SampleState(run[0][0])) for run in found]

    @property
    def reasons(self) -> Dict[int, Message]:
        """Why samples failed, by their index in the plan."""
        return dict(self._reasons)

    def note_stored(self, index: int) -> None:
        self._states[index] = SampleState.MEASURED
        self._reasons.pop(index, None)
        self._on_change(self)

    def note_failed(self, index: int, reason: Message) -> None:
        """Note that a sample could not be measured, unless it is stored already."""
        if self._states[index] != SampleState.MEASURED:
            self._states[index] = SampleState.FAILED
            self._reasons[index] = reason
            self._on_change(self)

    def verdict(self) -> Verdict:
        """Return the coverage in one sentence; only a full one is called complete."""
        failed = self._states.count(SampleState.FAILED)
        missing = self._states.count(SampleState.NOT_VISITED)
        return verdict(len(self._states), failed, missing)


@dataclass(frozen=True)
class Status:
    """A snapshot of the control.

    Attributes:
        state: What it is doing.
        message: What it is doing, or what went wrong and what to do.
        survey_id: The current or last survey; empty before the first.
        target: The point being visited; None while no survey runs.
        total_points: Traces of the plan.
        visited_points: Traces that are stored durably.
        remaining_s: Time to the end [s].
        missing: Which nodes do not answer; None if all answer.
        warning: A warning about the current or last survey; None if there is none.
        waiting: What is waited for longer than expected; None otherwise.
        plan_id: Of the parameters that are set, or of the current or last survey.
        plan_set_by: Node that set them.
        end: How that survey ended, until the next one begins; IDLE: it has not.
        ended_us: When [us since 1970, UTC].
    """

    state: SurveyState = SurveyState.IDLE
    message: Message = NO_PARAMETERS
    survey_id: str = ""
    target: Optional[SurveyPoint] = None
    total_points: int = 0
    visited_points: int = 0
    remaining_s: float = 0.0
    missing: Optional[Message] = None
    warning: Optional[Message] = None
    waiting: Optional[Message] = None
    plan_id: str = ""
    plan_set_by: str = ""
    end: SurveyState = SurveyState.IDLE
    ended_us: int = 0

    @property
    def full_message(self) -> Message:
        """What is waited for or the message, after a warning if there is one."""
        present = self.message if self.waiting is None else self.waiting
        warnings = [one for one in (self.missing, self.warning) if one is not None]
        if not warnings:
            return present
        warning = in_a_row(warnings) if len(warnings) > 1 else warnings[0]
        # The robot continues in spite of it, whatever it is.
        return Message("Warning: {warning}. {status}", warning=warning.as_warning(), status=present)

    def entered(self, state: SurveyState, message: Message, time_us: int) -> Status:
        """Return the status in a state that may follow, entered at a time [us since 1970, UTC]."""
        if state not in TRANSITIONS[self.state]:
            raise RequestRefusedError(
                Message(
                    "a survey that is {before} cannot become {after}",
                    before=self.state.label,
                    after=state.label,
                )
            )
        target = self.target if state.running else None
        end: Dict[str, Any] = {"end": state, "ended_us": time_us} if state in ENDED else {}
        return replace(self, state=state, message=message, target=target, waiting=None, **end)


class SurveyStatus:
    """Holds the status, allows only legal transitions, and announces every change."""

    def __init__(
        self,
        on_change: Callable[[Status, Status], None],
        on_parameters: Callable[[SurveyParameters], None],
        on_coverage: Callable[[Coverage, str], None],
    ) -> None:
        """Begin idle; of a change what was and what is, of the survey the rest is announced."""
        self._on_change, self._on_parameters = on_change, on_parameters
        self.on_coverage = on_coverage
        self._lock = threading.RLock()
        self._status = Status()

    @property
    def status(self) -> Status:
        return self._status

    def enter(self, state: SurveyState, message: Message, time_us: Optional[int] = None) -> None:
        """Enter a state that may follow, at a time [us since 1970, UTC]; None: now."""
        now_us = time_of_day_us() if time_us is None else time_us
        with self._lock:
            self._change(self._status.entered(state, message, now_us))

    def update(self, **changes: Any) -> None:
        """Change fields of the status other than the state."""
        with self._lock:
            self._change(replace(self._status, **changes))

    def set_plan(self, plan: SurveyPlan) -> None:
        """Enter CONFIGURED, and announce the parameters of the next survey."""
        ready = Message("Ready for {count} traces", count=plan.total_points)
        self._show_plan(plan, SurveyState.CONFIGURED, ready)

    def begin_survey(self, plan: SurveyPlan) -> None:
        """Enter CHECKING, and begin the progress of a survey, which may be stored in part."""
        self._show_plan(
            plan,
            SurveyState.CHECKING,
            Message("Checking the robot"),
            survey_id=plan.survey_id,
            total_points=plan.total_points,
            visited_points=len(plan.reopened.stored_indices),
            remaining_s=sum(plan.pending_durations_s),
            warning=None,
            end=SurveyState.IDLE,
            ended_us=0,
        )

    def _show_plan(
        self, plan: SurveyPlan, state: SurveyState, message: Message, **changes: Any
    ) -> None:
        changes.update(plan_id=plan.parameters.plan_id, plan_set_by=plan.set_by)
        with self._lock:
            planned = replace(self._status.entered(state, message, 0), **changes)
            self._on_parameters(plan.parameters)
            self._change(planned)

    def _change(self, status: Status) -> None:
        before, self._status = self._status, status
        self._on_change(before, status)
