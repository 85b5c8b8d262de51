"""The engine: carries out the steps of one survey, and ends it whatever happens."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, Optional, Union

from gpr20_main_control.errors import DeviceError, NodeLostError, StopRequested
from gpr20_main_control.mid import survey_steps as steps
from gpr20_main_control.mid.instruments import AnalyzerState, Instruments
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.recovery import REST_LIMIT_S, Recovery
from gpr20_main_control.mid.repeat_measurement import compare
from gpr20_main_control.mid.robot import Robot
from gpr20_main_control.mid.survey_archive import SurveyArchive, interruption_remark
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey_status import SurveyStatus
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace

# Traces that wait for the disk when a survey is stopped get this long to be stored [s].
STOPPING_LIMIT_S = 60.0
POLL_S = 0.05


class SurveyEngine:
    """Carries out one survey. `run` is the body of its thread."""

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        status: SurveyStatus,
        positioner: Positioner,
        interruption: Interruption,
    ) -> None:
        """Put together what carries out a plan; nothing happens before `run`.

        Raises:
            SurveyError: The report of the survey that is resumed cannot be read.
        """
        self._plan = plan
        self._status = status
        self._positioner = positioner
        self._interruption = interruption
        self._instruments = Instruments(plan, robot, positioner, interruption)
        self._archive = SurveyArchive(plan, robot, status, interruption.clock)
        limit_s = plan.settings.return_limit_s
        self._recovery = Recovery(positioner, status, interruption, limit_s)
        self._progress = steps.SurveyProgress.at_start(plan)
        self._pause_requested = threading.Event()
        self._resume = threading.Event()
        self._analyzer: Optional[AnalyzerState] = None
        self._remark = ""
        self._measured: Optional[Trace] = None
        self._actions: Dict[type, Callable[[Any], None]] = {
            steps.Check: self._check,
            steps.Open: self._open,
            steps.Home: self._home,
            steps.Repeat: self._repeat,
            steps.Move: self._move,
            steps.Measure: self._measure,
            steps.Store: self._store,
            steps.Finish: self._finish,
        }

    def run(self) -> None:
        """Carry out the survey; every way out ends in a final state with a message."""
        try:
            self._status.show_coverage(self._archive.coverage)
            while not self._continue():
                pass
        except StopRequested:
            self._end(SurveyState.STOPPED, "stopped", "stopped on request")
        except Exception as error:
            self._end(SurveyState.FAILED, "failed", str(error))
            if not isinstance(error, DeviceError):
                raise
        finally:
            self._archive.queue.close()

    def pause(self) -> None:
        """Hold after the sample that is being measured."""
        self._pause_requested.set()

    def resume(self) -> None:
        """Continue after a pause; the state says so already."""
        self._resume.set()

    def _continue(self) -> bool:
        """Carry out the steps that are left; False if the survey was interrupted meanwhile."""
        try:
            if self._carry_out_steps():
                return True
            self._hold("on request")
        except DeviceError as error:
            # A part that was stopped fails, too; that is no reason to pause.
            self._interruption.check_stop()
            self._recover_or_hold(error)
        return self._all_stored and self._finish_now()

    def _carry_out_steps(self) -> bool:
        """Carry out the steps to the end; False if a pause was requested on the way."""
        for step in steps.survey_steps(self._plan, self._progress):
            if isinstance(step, steps.Checkpoint):
                if self._pause_requested.is_set():
                    return False
                continue
            try:
                self._actions[type(step)](step)
            except DeviceError as error:
                if isinstance(step, (steps.Move, steps.Measure)):
                    self._archive.coverage.note_failed(step.point.index, str(error))
                raise
        return True

    def _check(self, _step: steps.Check) -> None:
        self._recovery.accept_nodes()
        self._analyzer = self._instruments.check()
        self._interruption.check()

    def _open(self, _step: steps.Open) -> None:
        assert self._analyzer is not None
        interrupted = self._archive.open(self._analyzer, self._interruption.check)
        self._remark = interruption_remark(interrupted)

    def _home(self, step: steps.Home) -> None:
        self._status.enter(SurveyState.HOMING, f"homing the axes{self._remark}")
        try:
            homed = self._positioner.home(again=step.every_axis)
        except DeviceError:
            # Some axes may have been homed, and nobody will know the next time.
            self._progress.repeat_last = True
            raise
        self._progress.note_homed(bool(homed))
        self._archive.queue.retry()
        self._status.enter(SurveyState.SURVEYING, "measuring")
        self._archive.start_timing()

    def _repeat(self, step: steps.Repeat) -> None:
        self._status.set_message(f"measuring point {step.point.index} again as a control")
        stored = self._progress.last
        assert stored is not None
        self._move(step)
        measured = self._instruments.measure(step.point)
        repeat = compare(stored, measured, measured.antennae_height_m)
        self._archive.note_repeat(repeat, self._interruption.check)
        self._progress.repeat_last = False
        self._status.set_message(f"measuring; {repeat.text}")

    def _move(self, step: Union[steps.Move, steps.Repeat]) -> None:
        self._status.set_target(step.point)
        self._interruption.check()
        self._positioner.move_to(step.point)

    def _measure(self, step: steps.Measure) -> None:
        self._measured = self._instruments.measure(step.point)

    def _store(self, _step: steps.Store) -> None:
        assert self._measured is not None
        trace, self._measured = self._measured, None
        # Counted before the wait for room: the trace is taken over even if that fails.
        self._progress.note_measured(trace)
        self._archive.queue.put(trace, self._interruption.check)

    def _finish(self, _step: steps.Finish) -> None:
        self._archive.queue.drain(self._interruption.check)
        self._close_finished()

    @property
    def _all_stored(self) -> bool:
        return (
            self._progress.measured == len(self._plan.pending) and not self._archive.queue.waiting
        )

    def _finish_now(self) -> bool:
        """End the survey, all of which is stored; whether that was possible as things are.

        A storage that died while it ended the survey may have ended it; such a survey cannot
        be opened again.
        """
        try:
            self._close_finished()
        except DeviceError as error:
            self._status.set_message(f"the survey is not ended yet: {error}")
            return False
        return True

    def _close_finished(self) -> None:
        verdict = self._archive.coverage.verdict()
        stored = self._archive.close("finished", verdict.text, self._interruption.check)
        total = self._plan.total_points
        if not verdict.complete or stored != total:
            self._status.enter(
                SurveyState.FAILED,
                f"{verdict.text}; the survey's folder holds {stored} of {total} traces",
            )
            return
        self._status.enter(
            SurveyState.FINISHED,
            f"finished, {verdict.text}; {stored} traces in {self._archive.folder}",
        )

    def _recover_or_hold(self, error: DeviceError) -> None:
        """Return when the survey can continue: because a node is back, or it was resumed."""
        reason = str(error)
        self._archive.stop_timing()
        lost = self._recovery.loss_behind(error)
        if lost and not self._pause_requested.is_set():
            try:
                self._recovery.wait_for_return(lost)
                return
            except NodeLostError as gone:
                reason = str(gone)
        if not self._archive.folder:
            raise DeviceError(reason) from error
        self._positioner.stop()
        requested = "on request; " if self._pause_requested.is_set() else ""
        self._hold(f"{requested}{reason}; resume when it is mended, or stop")

    def _hold(self, reason: str) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        self._archive.stop_timing()
        self._pause_requested.clear()
        self._resume.clear()
        self._status.enter(SurveyState.PAUSED, f"paused: {reason}")
        while not self._resume.is_set():
            self._interruption.check_stop()
            self._interruption.clock.wait_s(self._resume, POLL_S)
        self._recovery.note_resumed()

    def _end(self, state: SurveyState, outcome: str, reason: str) -> None:
        """End before the plan is done; nothing here may keep the rest from happening."""
        self._archive.stop_timing()
        self._positioner.stop()
        if state is SurveyState.STOPPED:
            self._status.enter(SurveyState.STOPPING, "stopping: storing what has been measured")
        message = reason
        if not self._positioner.wait_for_rest(REST_LIMIT_S):
            message += "; AN AXIS STILL MOVES: switch the motors off"
        if self._archive.folder:
            message += self._close_early(outcome, reason)
        self._status.enter(state, message)

    def _close_early(self, outcome: str, reason: str) -> str:
        check = self._recovery.return_limit_check()
        try:
            if self._recovery.nodes_changed:
                # The storage may be one of them, to which no survey is open.
                self._archive.reopen(check)
            self._archive.queue.retry()
            self._archive.queue.drain_within(STOPPING_LIMIT_S)
            stored = self._archive.close(outcome, reason, check)
        except Exception as error:
            # A fault of the software, too: the survey must not seem to be stopping for ever.
            return f"; the recordings could not be finished: {error}"
        return f"; {stored} of {self._plan.total_points} traces in {self._archive.folder}"
