"""The steps of a survey in their order: what is done before the first point, at each, between."""

from __future__ import annotations

import contextlib
from collections import deque
from typing import TYPE_CHECKING, Dict, Iterator, List, Optional, Sequence

from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import plain
from gpr20_main_control.errors import (
    DRIFTED,
    DeviceError,
    StopRequested,
    UnconfirmedError,
    message_of,
)
from gpr20_main_control.mid.measured_again import DriftLimits, KnownPoint, Repeated, known_traces
from gpr20_main_control.mid.survey.sampling import Confirmation, Sampling
from gpr20_main_control.mid.survey.survey_archive import CAPACITY
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_main_control.mid.waits import Check
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import VNA_FAILED
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import iso_text

if TYPE_CHECKING:  # the survey has these steps
    from gpr20_main_control.mid.survey.survey import Survey

MEASURING = Message("Measuring")


class SurveyProgress:
    """How far a survey is, from which its remaining steps follow.

    Attributes:
        unconfirmed: The sweep that is not confirmed yet; None if every one is.
        home_every_axis: Whether every axis must be homed, because the stored traces were measured
            before this process homed the axes.
        reference: The traces of the first stop, with which a visit of it is compared.
    """

    def __init__(self, plan: SurveyPlan) -> None:
        """Begin a survey, or continue one from its folder."""
        resumed = bool(plan.reopened.survey_id)
        self.home_every_axis = resumed
        self._plan, self._rotations = plan, len(plan.parameters.polarizations_deg)
        # Of two stops, of which one is complete.
        self._recent = deque(plan.reopened.recent, maxlen=max(1, 2 * self._rotations - 1))
        self._pending = deque(plan.pending)
        self.unconfirmed: Optional[Confirmation] = None
        self.reference: Dict[int, Trace] = {
            one.index: one for one in plan.reopened.recent if one.index < self._rotations
        }
        self._visited: Optional[int] = None
        self._visit_now = resumed and len(self.reference) == self._rotations

    @property
    def next(self) -> Optional[SurveyPoint]:
        """The point to measure next; None if every point is measured."""
        return self._pending[0] if self._pending else None

    @property
    def next_index(self) -> int:
        """Index of the point to measure next; the number of points if every one is measured."""
        return self._plan.total_points if self.next is None else self.next.index

    @property
    def all_confirmed(self) -> bool:
        """Whether every point is measured and its sweep is confirmed."""
        return not self._pending and self.unconfirmed is None

    @property
    def known(self) -> List[Trace]:
        """The stored traces of a known point, at every rotation so far."""
        return known_traces(self._recent, self._rotations)

    @property
    def visit_due(self) -> bool:
        """Whether the first stop is visited before another point is measured."""
        index, visits = self.next_index, self._plan.visits
        due = self._visit_now or (index in visits and index != self._visited)
        return bool(visits) and due and len(self.reference) == self._rotations

    def note_pause(self, duration_s: float) -> None:
        """Note how long the survey was paused [s]: as long as between visits, one is due."""
        interval_s = self._plan.settings.reference_interval_s / self._plan.config.time_scale
        self._visit_now |= duration_s >= interval_s

    def note_visited(self) -> None:
        self._visited, self._visit_now = self.next_index, False

    def note_swept(self, sweep: Confirmation) -> None:
        self.unconfirmed = sweep
        self._pending.popleft()

    def note_confirmed(self, trace: Trace) -> None:
        self.unconfirmed = None
        self._recent.append(trace)
        if trace.index < self._rotations:
            self.reference[trace.index] = trace

    def note_rejected(self) -> None:
        """Note that the sweep could not be confirmed: its point is the next to measure."""
        assert self.unconfirmed is not None
        self._pending.appendleft(self.unconfirmed.point)
        self.unconfirmed = None


class SurveySteps:
    """Executes the steps of one survey.

    Attributes:
        progress: How far it is.
    """

    def __init__(self, survey: Survey) -> None:
        self._survey, self._plan = survey, survey.plan
        self._status, self._positioner = survey.status, survey.positioner
        self._archive, self._zeros = survey.archive, survey.zeros
        self.progress = SurveyProgress(survey.plan)
        self._sampling = Sampling(survey)
        self._drift = DriftLimits(survey.plan.settings)
        self._rejections = 0
        self._rejection: Optional[Message] = None

    def run(self) -> bool:
        """Execute the remaining steps; return False if a pause was requested on the way.

        A survey that was interrupted, by a DeviceError too, is continued by calling this again.
        """
        progress, paused = self.progress, self._survey.pause_requested
        self._begin()
        self._home()
        if self._zeros.needs_proof(self._positioner.zeros()) and progress.known:
            self._compare(progress.known)
        while not progress.all_confirmed or progress.visit_due:
            point = progress.next
            if paused.is_set() and (point is not None or progress.visit_due):
                self._confirm()
                return False
            if progress.visit_due:
                self._confirm()
                # Not if the sweep was rejected: its point is measured again first.
                if progress.visit_due:
                    self._visit()
                continue
            if point is not None:
                with self._measuring(point):
                    self._move_to(point)
                    self._sampling.settle(point)
            # Beside the move, and before the next sweep.
            self._confirm()
            if point is not None and progress.next == point:
                with self._measuring(point):
                    store, remark = self._archive.queue.add, self._rejection
                    progress.note_swept(self._sampling.sweep(point, store, remark))
        return True

    def resolve_unconfirmed(self, check: Check) -> None:
        """Confirm the last sweep if that is possible; otherwise its point is measured again.

        An error of `check` gives the sweep up, but with StopRequested it remains unconfirmed.
        """
        sweep = self.progress.unconfirmed
        if sweep is None:
            return
        try:
            self.progress.note_confirmed(self._sampling.confirmed(sweep, check))
        except StopRequested:
            raise
        except Exception as error:
            # Faults in the software too: the survey is about to report another one.
            self._reject(sweep, message_of(error))

    def _begin(self) -> None:
        """Check every part of the robot, and make or reopen the survey's folder."""
        self._rejections = 0
        self._survey.robot.nodes.accept()
        self._survey.robot.nodes.check()
        analyzer = self._sampling.check(self.progress.next_index)
        self._survey.interruption.check()
        self._archive.open(analyzer, self._survey.interruption.check)

    def _home(self) -> None:
        self._status.enter(SurveyState.HOMING, Message("Homing the axes"))
        before, progress = self._positioner.zeros(), self.progress
        every = progress.home_every_axis
        self._positioner.home(before.keys() if every else self._zeros.to_home_again(before))
        present = self._positioner.zeros()
        self._zeros.note_homed(present)
        if not progress.known:
            self._zeros.begin(present, progress.next_index, self._now())
            self._note_zeros()
        progress.home_every_axis = False
        # Before the next trace: what it is measured with, and what its coordinates refer to.
        self._archive.send_report(self._survey.interruption.check)
        self._archive.queue.retry()
        self._status.enter(SurveyState.SURVEYING, MEASURING)

    def _compare(self, stored: Sequence[Trace]) -> None:
        """Measure a known point again, because the zeros are other ones than those before."""
        present = self._positioner.zeros()
        message = Message("Measuring point {index} again, to compare", index=stored[0].index)
        known = KnownPoint(self._repeated(stored, message, sweeps=1))
        limit_db, index = self._plan.settings.repeat_limit_db, self.progress.next_index
        self._zeros.judge(present, known, limit_db, index, self._now())
        self._note_zeros(known.repeats)
        self._archive.send_report(self._survey.interruption.check)
        self._status.update(message=in_a_row([MEASURING, known.message]))

    def _visit(self) -> None:
        """Measure the first stop again, and pause if it has drifted too far."""
        stored = [trace for _, trace in sorted(self.progress.reference.items())]
        message = Message("Measuring the first stop again, to see the drift")
        repeated = self._repeated(stored, message, sweeps=2)
        visit = self._drift.visit(repeated, self.progress.next_index, self._now())
        self._archive.add_fact(Kind.DRIFT, **visit.values)
        self._archive.send_facts(self._survey.interruption.check)
        if visit.exceeded:
            if self.progress.next is not None:
                raise DeviceError(visit.message, fault=DRIFTED)
            # Nothing is left to measure: the operator need not decide.
            self._survey.show_warning(visit.message.with_fault(DRIFTED))
        self.progress.note_visited()
        self._status.update(message=in_a_row([MEASURING, visit.message]))

    def _repeated(self, stored: Sequence[Trace], message: Message, sweeps: int) -> List[Repeated]:
        """Measure the points of stored traces again; nothing of it is stored among the traces."""
        self._status.update(message=message)
        found = []
        for trace in stored:
            point = self._plan.points[trace.index]
            self._move_to(point)
            self._sampling.settle(point)
            found.append(Repeated(trace, tuple(self._swept_again(point) for _ in range(sweeps))))
        return found

    def _swept_again(self, point: SurveyPoint) -> Trace:
        for attempt in range(self._plan.settings.attempts):
            try:
                return self._sampling.confirmed(self._sampling.sweep(point, lambda _trace: None))
            except UnconfirmedError as error:
                if not error.repeat or attempt + 1 == self._plan.settings.attempts:
                    raise
        raise AssertionError("the last attempt returns or raises")

    def _move_to(self, point: SurveyPoint) -> None:
        self._survey.interruption.check()
        # Announced when the axes have begun to move, which need not wait for it.
        target = {AxisId.X: point.x_mm, AxisId.Y: point.y_mm, AxisId.Z: point.z_deg}
        self._positioner.move(target, lambda: self._status.update(target=point))

    @contextlib.contextmanager
    def _measuring(self, point: SurveyPoint) -> Iterator[None]:
        try:
            yield
        except DeviceError as error:
            self._survey.coverage.note_failed(point.index, error.message)
            raise

    def _confirm(self) -> None:
        """Wait until the sweep before, if any, is confirmed; it is stored in the background."""
        sweep = self.progress.unconfirmed
        if sweep is None:
            return
        try:
            trace = self._sampling.confirmed(sweep)
        except UnconfirmedError as error:
            self._reject(sweep, error.message)
            self._measure_again(sweep.point, error)
            return
        if self._rejections:
            self._status.update(message=MEASURING)
        self._rejections, self._rejection = 0, None
        self.progress.note_confirmed(trace)
        self._archive.wait_until_left(CAPACITY, sweep.point)

    def _measure_again(self, point: SurveyPoint, error: UnconfirmedError) -> None:
        if not error.repeat:
            raise error
        self._rejections += 1
        if self._rejections >= self._plan.settings.attempts:
            raise DeviceError(
                Message(
                    "the sweep at point {index} was not confirmed {count} times in a row: {reason}",
                    index=point.index,
                    count=self._rejections,
                    reason=error.message,
                ),
                fault=VNA_FAILED,
            ) from error
        if self._rejection is not None:
            self._status.update(message=self._rejection.as_warning())

    def _reject(self, sweep: Confirmation, reason: Message) -> None:
        """Give up a sweep, unless its trace is accepted for storing already."""
        trace = sweep.give_up()
        if trace is not None:
            self.progress.note_confirmed(trace)
            return
        self.progress.note_rejected()
        self._survey.coverage.note_failed(sweep.point.index, reason)
        self._rejection = Message(
            "point {index} is measured again, because its sweep was not confirmed: {reason}",
            index=sweep.point.index,
            reason=reason,
        )
        self._survey.report.note_warning(self._rejection)

    def _note_zeros(self, compared: Sequence[Repeated] = ()) -> None:
        values = plain(self._zeros.used[-1])
        self._archive.add_fact(Kind.EPOCH, **values, compared=[one.values for one in compared])

    def _now(self) -> str:
        return iso_text(self._survey.clock.time_of_day_us())
