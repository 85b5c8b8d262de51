"""Executing the steps of a survey."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional

from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import plain
from gpr20_main_control.errors import DeviceError, StopRequested, UnconfirmedError, message_of
from gpr20_main_control.mid.devices.instruments import AnalyzerState, Instruments
from gpr20_main_control.mid.survey import survey_steps as steps
from gpr20_main_control.mid.survey.drift_record import Revisit
from gpr20_main_control.mid.survey.known_point import compare_known_point
from gpr20_main_control.mid.survey.recovery import Recovery
from gpr20_main_control.mid.survey.running_survey import RunningSurvey
from gpr20_main_control.mid.survey.sampling import Sampling
from gpr20_main_control.mid.survey.survey_archive import SurveyArchive, interruption_remark
from gpr20_main_control.mid.survey.survey_ending import SurveyEnding
from gpr20_main_control.mid.waits import Check
from gpr20_survey.faults import VNA_FAILED
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import iso_text

MEASURING = Message("Measuring")


class StepActions:
    """Executes single steps; the engine decides on their order."""

    def __init__(
        self,
        survey: RunningSurvey,
        instruments: Instruments,
        sampling: Sampling,
        archive: SurveyArchive,
        recovery: Recovery,
        ending: SurveyEnding,
    ) -> None:
        self._survey = survey
        self._plan, self._progress = survey.plan, survey.progress
        self._status, self._positioner = survey.status, survey.positioner
        self._interruption, self._waits = survey.interruption, survey.waits
        self._instruments = instruments
        self._sampling = sampling
        self._archive = archive
        self._recovery = recovery
        self._ending = ending
        self._analyzer: Optional[AnalyzerState] = None
        self._remark: Optional[Message] = None
        self._rejections = 0
        self._rejection: Optional[Message] = None
        self._actions: Dict[type, Callable[[Any], None]] = {
            steps.Check: self._check,
            steps.Open: self._open,
            steps.Home: self._home,
            steps.Compare: self._compare,
            steps.Visit: self._visit,
            steps.Move: self._move,
            steps.Settle: self._settle,
            steps.Confirm: self._confirm,
            steps.Sweep: self._sweep,
            steps.Finish: self._finish,
        }

    def execute(self, step: steps.Step) -> None:
        """Execute a step.

        Raises:
            DeviceError: It failed.
            StopRequested: A stop of the survey was requested.
        """
        try:
            self._actions[type(step)](step)
        except DeviceError as error:
            if isinstance(step, (steps.Move, steps.Settle, steps.Sweep)):
                self._survey.coverage.note_failed(step.point.index, error.message)
            raise

    def resolve_unconfirmed(self, check: Check) -> None:
        """Confirm the last sweep if that is possible; otherwise its point is measured again.

        Args:
            check: Called repeatedly meanwhile; an error that it raises gives the sweep up.

        Raises:
            StopRequested: `check` raised it; the sweep remains unconfirmed.
        """
        point = self._progress.unconfirmed
        if point is None:
            return
        try:
            self._progress.note_confirmed(self._sampling.confirmed(point, check))
        except StopRequested:
            raise
        except Exception as error:
            # Faults in the software too: the survey is about to report another one.
            self._reject(point, message_of(error))

    def _check(self, _step: steps.Check) -> None:
        self._rejections = 0
        self._recovery.accept_nodes()
        self._analyzer = self._instruments.check(self._next_index)
        self._interruption.check()

    def _open(self, _step: steps.Open) -> None:
        assert self._analyzer is not None
        interrupted = self._archive.open(self._analyzer, self._interruption.check)
        self._remark = interruption_remark(interrupted)

    def _home(self, step: steps.Home) -> None:
        homing = Message("Homing the axes")
        if self._remark is not None:
            homing = in_a_row([homing, self._remark])
        self._status.enter(SurveyState.HOMING, homing)
        self._find_zeros(step.every_axis)
        self._archive.queue.retry()
        self._status.enter(SurveyState.SURVEYING, MEASURING)
        self._archive.start_timing()

    def _find_zeros(self, every_axis: bool) -> None:
        zeros = self._survey.zeros
        before = self._positioner.zeros()
        again = before.keys() if every_axis else zeros.to_home_again(before)
        homed = self._positioner.home(again)
        present = self._positioner.zeros()
        zeros.note_homed(homed, present)
        if self._progress.last is None:
            zeros.begin(present, self._next_index, self._now())
            self._note_zeros()
        self._progress.note_homed(zeros.needs_proof(present))

    def _compare(self, step: steps.Compare) -> None:
        """Compare a known point with its stored traces, because the zeros are other ones."""
        present = self._positioner.zeros()
        measured = []
        for stored in step.stored:
            point = self._plan.points[stored.index]
            self._status.set_message(
                Message("Measuring point {index} again, to compare", index=point.index)
            )
            self._move_to(point)
            self._sampling.settle(point, compared=True)
            measured.append(self._repeated(point))
        known = compare_known_point(step.stored, measured)
        try:
            self._survey.zeros.judge(
                present,
                known,
                self._plan.settings.repeat_limit_db,
                self._next_index,
                self._now(),
            )
            self._note_zeros()
        finally:
            self._archive.note_repeats(known.repeats, self._interruption.check)
        self._progress.compare = False
        self._status.set_message(in_a_row([MEASURING, known.message]))

    def _note_zeros(self) -> None:
        self._survey.notes.add(Kind.EPOCH, **plain(self._survey.zeros.used[-1]))

    @property
    def _next_index(self) -> int:
        point = self._progress.next
        return self._plan.total_points if point is None else point.index

    def _now(self) -> str:
        return iso_text(self._survey.clock.time_of_day_us())

    def _visit(self, step: steps.Visit) -> None:
        """Measure the reference again, and pause if it has drifted too far."""
        self._status.set_message(Message("Measuring the first stop again, to see the drift"))
        revisits: List[Revisit] = []
        for stored in step.stored:
            point = self._plan.points[stored.index]
            self._move_to(point)
            self._sampling.settle(point)
            revisits.append(Revisit(stored, self._repeated(point), self._repeated(point)))
        drift = self._survey.drift
        visit = drift.visit(revisits, self._next_index, self._now())
        self._survey.notes.add(Kind.DRIFT, **visit.values)
        self._archive.send_notes(self._interruption.check)
        if visit.exceeded:
            exceeded = drift.ask(visit)
            if self._progress.next is not None:
                raise exceeded
            # Nothing is left to measure: the operator need not decide.
            self._survey.show_warning(exceeded.message)
        self._progress.note_visited()
        self._status.set_message(in_a_row([MEASURING, visit.message]))

    def _repeated(self, point: SurveyPoint) -> Trace:
        """Measure a point that is stored already, at which the axes have settled."""
        for attempt in range(self._plan.settings.attempts):
            try:
                self._sampling.sweep(point, lambda _trace: None)
                return self._sampling.confirmed(point)
            except UnconfirmedError as error:
                if not error.repeat or attempt + 1 == self._plan.settings.attempts:
                    raise
            finally:
                self._sampling.give_up()
        raise AssertionError("the last attempt returns or raises")

    def _move(self, step: steps.Move) -> None:
        self._move_to(step.point)

    def _move_to(self, point: SurveyPoint) -> None:
        self._interruption.check()
        # Announced when the axes have begun to move, which need not wait for it.
        self._positioner.move_to(point, lambda: self._status.set_target(point))

    def _settle(self, step: steps.Settle) -> None:
        self._sampling.settle(step.point)

    def _sweep(self, step: steps.Sweep) -> None:
        self._sampling.sweep(step.point, self._archive.queue.add, self._rejection)
        self._progress.note_swept()

    def _confirm(self, step: steps.Confirm) -> None:
        try:
            trace = self._sampling.confirmed(step.point)
        except UnconfirmedError as error:
            self._reject(step.point, error.message)
            self._measure_again(step.point, error)
            return
        if self._rejections:
            self._status.set_message(MEASURING)
        self._rejections, self._rejection = 0, None
        self._progress.note_confirmed(trace)
        with self._waits.shown(self._archive.storing_wait(step.point)) as check:
            self._archive.queue.wait_for_room(check)

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
        self._status.set_message(
            Message(
                "Measuring point {index} again: {reason}", index=point.index, reason=error.message
            ).as_warning()
        )

    def _reject(self, point: SurveyPoint, reason: Message) -> None:
        """Give up the last sweep, unless its trace is accepted for storing already."""
        trace = self._sampling.give_up()
        if trace is not None:
            self._progress.note_confirmed(trace)
            return
        self._progress.note_rejected()
        self._survey.coverage.note_failed(point.index, reason)
        self._rejection = Message("measured again: {reason}", reason=reason)
        self._survey.note_warning(
            Message(
                "the sweep at point {index} was not confirmed and is not stored: {reason}",
                index=point.index,
                reason=reason,
            )
        )

    def _finish(self, _step: steps.Finish) -> None:
        with self._waits.shown(self._archive.storing_wait(self._plan.points[-1])) as check:
            self._archive.queue.drain(check)
        self._ending.close_finished(self._interruption.check)
