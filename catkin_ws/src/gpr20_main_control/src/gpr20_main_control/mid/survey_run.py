"""One survey, from its checks to its end."""

from __future__ import annotations

import threading
import uuid
from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError, NodeLostError, StopRequested
from gpr20_main_control.mid.background import Turns
from gpr20_main_control.mid.control_measurement import compare
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.measurement import PointMeasurement
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import Preparation
from gpr20_main_control.mid.recovery import REST_LIMIT_S, Recovery
from gpr20_main_control.mid.robot import Robot
from gpr20_main_control.mid.status_board import StatusBoard
from gpr20_main_control.mid.storage_queue import StorageQueue
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey_report import SurveyReport
from gpr20_survey.plan.survey_estimate import RemainingTime
from gpr20_survey.plan.survey_plan import SurveyPoint
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace

# Traces that wait for the disk when a survey is stopped get this long to be stored [s].
STOPPING_LIMIT_S = 60.0
POLL_S = 0.05


class SurveyRun:
    """Carries out one plan. `run` is the body of the survey's thread."""

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        positioner: Positioner,
        preparation: Preparation,
        measurement: PointMeasurement,
        report: SurveyReport,
        recovery: Recovery,
        board: StatusBoard,
        interruption: Interruption,
        storage_turns: Turns,
        clock: Clock,
        utc_now_us: Callable[[], int],
    ) -> None:
        self._plan = plan
        self._robot = robot
        self._positioner = positioner
        self._preparation = preparation
        self._measurement = measurement
        self._report = report
        self._recovery = recovery
        self._board = board
        self._interruption = interruption
        self._storage_turns = storage_turns
        self._clock = clock
        self._utc_now_us = utc_now_us
        self._pause_requested = threading.Event()
        self._resume = threading.Event()
        self._queue = StorageQueue(robot.storage, clock, self._count_stored)
        self._pending = plan.pending
        self._remaining = RemainingTime(plan.pending_durations_s)
        self._next = 0
        self._last = plan.last
        self._home_again = self._compare_again = preparation.survey_is_open
        self._surveying_since_s: Optional[float] = None
        self._surveyed_s = 0.0
        self._closing_report = ""

    def run(self) -> None:
        """Carry out the survey; every way out ends in a final state with a message."""
        try:
            self._report.announce()
            self._survey()
        except StopRequested:
            self._end(SurveyState.STOPPED, "stopped", "stopped on request")
        except Exception as error:
            self._end(SurveyState.FAILED, "failed", str(error))
            if not isinstance(error, DeviceError):
                raise
        finally:
            self._queue.close()

    def pause(self) -> None:
        """Hold after the sample that is being measured."""
        self._pause_requested.set()

    def resume(self) -> None:
        """Go on after a pause; the state says so already."""
        self._resume.set()

    def _survey(self) -> None:
        while True:
            try:
                self._prepare()
                if self._measure_pending():
                    self._queue.drain(self._interruption.check)
                    self._finish()
                    return
                self._hold("on request")
            except DeviceError as error:
                # A part that was told to stop fails, too; that is no reason to pause.
                self._interruption.check_stop()
                self._recover_or_hold(error)
            if self._all_stored and self._finish_now():
                return

    def _prepare(self) -> None:
        self._recovery.begin()
        self._preparation.check()
        self._interruption.check()
        remark = self._preparation.open_survey()
        self._board.enter(SurveyState.HOMING, f"homing the axes{remark}")
        try:
            homed = self._positioner.home(again=self._home_again)
        except DeviceError:
            # Some axes may have been homed, and nobody will know the next time.
            self._compare_again = True
            raise
        self._home_again = False
        self._compare_again = self._compare_again or bool(homed)
        self._queue.retry()
        self._board.enter(SurveyState.SURVEYING, "measuring")
        self._surveying_since_s = self._clock.now_s()

    def _measure_pending(self) -> bool:
        """Measure until all is measured; False if a pause was requested before."""
        if self._compare_again and self._last is not None:
            self._measure_control(self._last)
        self._compare_again = False
        while self._next < len(self._pending):
            if self._pause_requested.is_set():
                return False
            self._visit(self._pending[self._next])
        return True

    def _measure_control(self, stored: Trace) -> None:
        self._board.say(f"measuring point {stored.index} again as a control")
        point = self._plan.points[stored.index]
        self._board.aim(point)
        measured = self._measurement.measure(point)
        control = compare(stored, measured.sweep, measured.height_m)
        self._report.note_control(control, self._utc_now_us())
        report_json = self._report.to_json()
        self._storage_turns.take(
            lambda: self._robot.storage.report(self._plan.survey_id, report_json),
            self._interruption.check,
        )
        self._board.say(f"measuring; {control.text}")

    def _visit(self, point: SurveyPoint) -> None:
        self._board.aim(point)
        try:
            measured = self._measurement.measure(point)
        except DeviceError as error:
            self._report.note_failed(point.index, str(error))
            raise
        sweep = measured.sweep
        trace = Trace(
            survey_id=self._plan.survey_id,
            sample_id=str(uuid.uuid4()),
            index=point.index,
            timestamp_us=self._utc_now_us(),
            x_coord_mm=measured.position.x_mm,
            y_coord_mm=measured.position.y_mm,
            z_coord_deg=measured.position.z_deg,
            antennae_height_m=measured.height_m,
            frequency_hz=sweep.frequency_hz,
            s21_real=sweep.s21_real,
            s21_imag=sweep.s21_imag,
            sweep_started_us=sweep.sweep_started_us,
            sweep_ended_us=sweep.sweep_ended_us,
            quality=measured.remarks,
        )
        # Counted before the wait for room: the queue has the trace even if that fails.
        self._next += 1
        self._last = trace
        self._queue.put(trace, self._interruption.check)

    def _recover_or_hold(self, error: DeviceError) -> None:
        """Return when the survey can go on: because a node is back, or it was resumed."""
        reason = str(error)
        self._hold_time()
        lost = self._recovery.loss_behind(error)
        if lost and not self._pause_requested.is_set():
            try:
                self._recovery.wait_for_return(lost)
                return
            except NodeLostError as gone:
                reason = str(gone)
        if not self._preparation.survey_is_open:
            raise DeviceError(reason) from error
        self._positioner.stop()
        requested = "on request; " if self._pause_requested.is_set() else ""
        self._hold(f"{requested}{reason}; resume when it is mended, or stop")

    @property
    def _all_stored(self) -> bool:
        return self._next == len(self._pending) and not self._queue.waiting

    def _finish_now(self) -> bool:
        """End the survey, all of which is stored; whether that was possible as things are.

        A storage that died while it ended the survey may have ended it; such a survey cannot
        be opened again.
        """
        try:
            self._finish()
        except DeviceError as error:
            self._board.say(f"the survey is not ended yet: {error}")
            return False
        return True

    def _hold(self, reason: str) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        self._hold_time()
        self._pause_requested.clear()
        self._resume.clear()
        self._board.enter(SurveyState.PAUSED, f"paused: {reason}")
        while not self._resume.is_set():
            self._interruption.check_stop()
            self._clock.wait_s(self._resume, POLL_S)
        self._recovery.note_progress()

    def _finish(self) -> None:
        verdict = self._report.coverage.verdict()
        stored = self._close("finished", verdict.text, self._interruption.check)
        total = len(self._plan.points)
        if not verdict.complete or stored != total:
            self._board.enter(
                SurveyState.FAILED,
                f"{verdict.text}; the survey's folder holds {stored} of {total} traces",
            )
            return
        self._board.enter(
            SurveyState.FINISHED,
            f"finished, {verdict.text}; {stored} traces in {self._preparation.folder}",
        )

    def _end(self, state: SurveyState, outcome: str, reason: str) -> None:
        """End before the plan is done; nothing here may keep the rest from happening."""
        self._hold_time()
        self._positioner.stop()
        if state is SurveyState.STOPPED:
            self._board.enter(SurveyState.STOPPING, "stopping: storing what has been measured")
        message = reason
        if not self._positioner.wait_for_rest(REST_LIMIT_S):
            message += "; AN AXIS STILL MOVES: switch the motors off"
        if self._preparation.survey_is_open:
            message += self._close_early(outcome, reason)
        self._board.enter(state, message)

    def _close_early(self, outcome: str, reason: str) -> str:
        patience = self._recovery.patience()
        try:
            if self._recovery.nodes_changed:
                # The storage may be one of them, to which no survey is open.
                self._preparation.open_survey(patience)
            self._queue.retry()
            self._queue.drain_within(STOPPING_LIMIT_S)
            stored = self._close(outcome, reason, patience)
        except DeviceError as error:
            return f"; the recordings could not be finished: {error}"
        return f"; {stored} of {len(self._plan.points)} traces in {self._preparation.folder}"

    def _close(self, outcome: str, reason: str, check: Callable[[], None]) -> int:
        storage, survey_id = self._robot.storage, self._plan.survey_id
        report_json = self._report.to_json()
        if report_json != self._closing_report:
            self._storage_turns.take(lambda: storage.report(survey_id, report_json), check)
        # Not twice: a survey that was closed by a call whose answer was lost takes no report.
        self._closing_report = report_json
        return self._storage_turns.take(lambda: storage.close(survey_id, outcome, reason), check)

    def _count_stored(self, stored: int, index: int) -> None:
        self._report.note_stored(index)
        self._recovery.note_progress()
        elapsed_s = self._surveyed_s
        if self._surveying_since_s is not None:
            elapsed_s += self._clock.now_s() - self._surveying_since_s
        self._board.progress(
            len(self._plan.stored) + stored, self._remaining.remaining_s(stored, elapsed_s)
        )

    def _hold_time(self) -> None:
        if self._surveying_since_s is not None:
            self._surveyed_s += self._clock.now_s() - self._surveying_since_s
            self._surveying_since_s = None
