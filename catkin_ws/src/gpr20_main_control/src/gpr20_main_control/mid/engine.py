"""The engine executes the steps of one survey, and ends it whatever happens."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Optional, Union

from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import (
    DeviceError,
    NodeLostError,
    ShutDownRequested,
    StopRequested,
    message_of,
)
from gpr20_main_control.mid import survey_steps as steps
from gpr20_main_control.mid.clock_steps import ClockSteps
from gpr20_main_control.mid.instruments import AnalyzerState, Instruments
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.recovery import REST_LIMIT_S, Recovery
from gpr20_main_control.mid.repeat_measurement import compare
from gpr20_main_control.mid.robot import Robot
from gpr20_main_control.mid.survey_archive import Check, SurveyArchive, interruption_remark
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey_status import SurveyStatus
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace

# Time to store the traces that wait for the disk when a survey is stopped [s].
STOPPING_LIMIT_S = 60.0
# Steps of a shutdown; roslaunch kills a node that has not ended 15 s after Ctrl-C [s].
LEAVING_LIMIT_S = 2.5
POLL_S = 0.05


class SurveyEngine:
    """Executes one survey. `run` is the body of its thread."""

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        status: SurveyStatus,
        positioner: Positioner,
        interruption: Interruption,
    ) -> None:
        """Prepare the execution of a plan; nothing happens before `run`.

        Raises:
            SurveyError: The report of the survey that is resumed cannot be read.
        """
        self._plan = plan
        self._status = status
        self._positioner = positioner
        self._interruption = interruption
        self._archive = SurveyArchive(plan, robot, status, interruption.clock)
        self._clock_steps = ClockSteps(interruption.clock, plan.last, self._note_clock_step)
        self._instruments = Instruments(plan, robot, positioner, interruption, self._clock_steps)
        limit_s = plan.settings.return_limit_s
        self._recovery = Recovery(positioner, status, interruption, limit_s)
        self._progress = steps.SurveyProgress.at_start(plan)
        self._pause_requested = threading.Event()
        self._resume = threading.Event()
        self._analyzer: Optional[AnalyzerState] = None
        self._remark: Optional[Message] = None
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
        """Execute the survey; it always ends in a final state with a message."""
        try:
            self._status.show_coverage(self._archive.coverage)
            while not self._continue():
                pass
        except ShutDownRequested:
            self._leave()
        except StopRequested:
            stopped = Message("Stopped on request")
            self._end(SurveyState.STOPPED, "stopped", stopped, stopped)
        except Exception as error:
            reason = message_of(error)
            failed = Message("Failed: {reason}", reason=reason)
            self._end(SurveyState.FAILED, "failed", failed, reason)
            if not isinstance(error, DeviceError):
                raise
        finally:
            self._archive.queue.close()

    def pause(self) -> None:
        """Pause after the present trace."""
        self._pause_requested.set()

    def resume(self) -> None:
        """Continue after a pause; the caller has changed the state."""
        self._resume.set()

    def _continue(self) -> bool:
        """Execute the remaining steps; return False if the survey was interrupted."""
        try:
            if self._execute_steps():
                return True
            self._wait_paused(Message("Paused on request. Resume the survey, or stop it."))
        except DeviceError as error:
            # A stop makes parts fail too; that is no reason to pause.
            self._interruption.check_stop()
            self._recover_or_pause(error)
        return self._all_stored and self._finish_now(self._interruption.check)

    def _execute_steps(self) -> bool:
        """Execute the steps to the end; return False if a pause was requested on the way."""
        for step in steps.survey_steps(self._plan, self._progress):
            if isinstance(step, steps.Checkpoint):
                if self._pause_requested.is_set():
                    return False
                continue
            try:
                self._actions[type(step)](step)
            except DeviceError as error:
                if isinstance(step, (steps.Move, steps.Measure)):
                    self._archive.coverage.note_failed(step.point.index, error.message)
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
        homing = Message("Homing the axes")
        if self._remark is not None:
            homing = in_a_row([homing, self._remark])
        self._status.enter(SurveyState.HOMING, homing)
        try:
            homed = self._positioner.home(again=step.every_axis)
        except DeviceError:
            # Some axes may have been homed, which the next attempt cannot see.
            self._progress.repeat_last = True
            raise
        self._progress.note_homed(bool(homed))
        self._archive.queue.retry()
        self._status.enter(SurveyState.SURVEYING, Message("Measuring"))
        self._archive.start_timing()

    def _repeat(self, step: steps.Repeat) -> None:
        self._status.set_message(
            Message("Measuring point {index} again, to compare", index=step.point.index)
        )
        stored = self._progress.last
        assert stored is not None
        self._move(step)
        measured = self._instruments.measure(step.point)
        repeat = compare(stored, measured, measured.antennae_height_m)
        self._archive.note_repeat(repeat, self._interruption.check)
        self._progress.repeat_last = False
        self._status.set_message(in_a_row([Message("Measuring"), repeat.message]))

    def _move(self, step: Union[steps.Move, steps.Repeat]) -> None:
        self._status.set_target(step.point)
        self._interruption.check()
        self._positioner.move_to(step.point)

    def _measure(self, step: steps.Measure) -> None:
        self._measured = self._instruments.measure(step.point)

    def _store(self, _step: steps.Store) -> None:
        assert self._measured is not None
        trace, self._measured = self._measured, None
        # Counted before the wait for room: the trace is accepted even if that fails.
        self._progress.note_measured(trace)
        self._archive.queue.put(trace, self._interruption.check)

    def _finish(self, _step: steps.Finish) -> None:
        self._archive.queue.drain(self._interruption.check)
        self._close_finished(self._interruption.check)

    @property
    def _all_stored(self) -> bool:
        return (
            self._progress.measured == len(self._plan.pending) and not self._archive.queue.waiting
        )

    def _finish_now(self, check: Check) -> bool:
        """Close the survey, all traces of which are stored; return whether that was possible.

        A storage that died while it closed the survey may have closed it; such a survey cannot
        be reopened.
        """
        try:
            self._close_finished(check)
        except DeviceError as error:
            self._status.set_message(
                Message("The survey is not closed yet: {reason}", reason=error.message)
            )
            return False
        return True

    def _note_clock_step(self, warning: Message) -> None:
        self._archive.note_warning(warning)
        self._status.set_warning(warning)

    def _close_finished(self, check: Check) -> None:
        self._clock_steps.check()
        verdict = self._archive.coverage.verdict()
        stored, total = self._archive.send_last_report(check), self._plan.total_points
        if verdict.complete and stored == total:
            state, outcome = SurveyState.FINISHED, "finished"
            message = Message(
                "Finished, {verdict}; {stored} traces in {folder}",
                verdict=verdict.message,
                stored=stored,
                folder=self._archive.folder,
            )
        else:
            state, outcome = SurveyState.FAILED, "failed"
            message = Message(
                "Failed: the survey's folder holds {stored} of {total} traces; {verdict}",
                stored=stored,
                total=total,
                verdict=verdict.message,
            )
        self._archive.close(outcome, verdict.message, state, message, check)
        self._status.enter(state, message)

    def _recover_or_pause(self, error: DeviceError) -> None:
        """Return when the survey can continue: because a node is back, or it was resumed."""
        reason = error.message
        self._archive.stop_timing()
        lost = self._recovery.loss_behind(error)
        if lost is not None and not self._pause_requested.is_set():
            try:
                self._recovery.wait_for_return(lost)
                return
            except NodeLostError as not_back:
                reason = not_back.message
        if not self._archive.folder:
            raise DeviceError(reason) from error
        self._positioner.stop()
        if self._pause_requested.is_set():
            paused = Message(
                "Paused on request, and a part failed: {reason}. Fix the fault and resume, or "
                "stop.",
                reason=reason,
            )
        else:
            paused = Message("Paused: {reason}. Fix the fault and resume, or stop.", reason=reason)
        self._wait_paused(paused)

    def _wait_paused(self, message: Message) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        self._archive.stop_timing()
        self._pause_requested.clear()
        self._resume.clear()
        self._status.enter(SurveyState.PAUSED, message)
        while not self._resume.is_set():
            self._interruption.check_stop()
            self._clock_steps.check()
            self._interruption.clock.wait_s(self._resume, POLL_S)
        self._recovery.note_resumed()

    def _leave(self) -> None:
        """Leave the survey, because the main control ends: interrupted, unless it is complete."""
        self._archive.stop_timing()
        self._positioner.stop()
        if self._all_stored and self._finish_now(self._archive.leaving_check(LEAVING_LIMIT_S)):
            return
        message = Message("Interrupted: the robot is shut down. Resume the survey later.")
        self._status.enter(SurveyState.STOPPING, message)
        self._positioner.wait_for_rest(LEAVING_LIMIT_S)
        if self._archive.folder:
            self._archive.interrupt(message, self._archive.leaving_check(LEAVING_LIMIT_S))
        self._status.enter(SurveyState.STOPPED, message)

    def _end(self, state: SurveyState, outcome: str, message: Message, reason: Message) -> None:
        """End the survey early; a failure of one action here must not prevent the next."""
        self._archive.stop_timing()
        self._positioner.stop()
        if state is SurveyState.STOPPED:
            stopping = Message("Stopping: storing the measured traces")
            self._status.enter(SurveyState.STOPPING, stopping)
        messages = [message]
        if not self._positioner.wait_for_rest(REST_LIMIT_S):
            messages.append(Message("AN AXIS IS STILL MOVING: switch the motors off"))
        ended = in_a_row(messages)
        if self._archive.folder:
            ended = self._close_early(state, outcome, messages, reason)
        self._status.enter(state, ended)

    def _close_early(
        self, state: SurveyState, outcome: str, messages: List[Message], reason: Message
    ) -> Message:
        """Close the survey's folder; return what the last status says."""
        self._clock_steps.check()
        check = self._recovery.return_limit_check()
        try:
            if self._recovery.nodes_changed:
                # The storage may be one of them, and may have no open survey.
                self._archive.reopen(check)
            self._archive.queue.retry()
            self._archive.queue.drain_within(STOPPING_LIMIT_S)
            count = Message(
                "{stored} of {total} traces in {folder}",
                stored=self._archive.send_last_report(check),
                total=self._plan.total_points,
                folder=self._archive.folder,
            )
            message = in_a_row([*messages, count])
            self._archive.close(outcome, reason, state, message, check)
        except Exception as error:
            # Faults in the software too: the survey must not remain STOPPING for ever.
            unfinished = Message(
                "the recordings could not be finished: {reason}", reason=message_of(error)
            )
            return in_a_row([*messages, unfinished])
        return message
