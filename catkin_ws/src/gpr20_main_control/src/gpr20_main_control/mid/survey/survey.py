"""One survey: its state, and how it is interrupted, paused, resumed and ended.

`survey_steps` says what is done at each point, `waits` what may interrupt a wait.
"""

from __future__ import annotations

import contextlib
import threading
from dataclasses import asdict, dataclass
from typing import Optional

from gpr20_common.faults import DISK_REFUSES, INTERNAL, PART_RED
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import (
    DeviceError,
    NodeLostError,
    OtherAnalyzerError,
    ShutDownRequested,
    StopRequested,
    message_of,
)
from gpr20_main_control.mid.devices.positioner import Positioner
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.survey.survey_archive import SurveyArchive
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey.survey_report import ClockSteps, SurveyReport
from gpr20_main_control.mid.survey.survey_status import Coverage, SurveyStatus
from gpr20_main_control.mid.survey.survey_steps import SurveySteps
from gpr20_main_control.mid.waits import POLL_S, REST_LIMIT_S, Check, Interruption, WaitStatus
from gpr20_survey.faults import CAN_RESUME, STOPPED, VNA_SILENT
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.survey_state import SurveyState

# A survey that loses nodes more often than this without storing a trace in between is paused.
MOST_RECOVERIES = 3
# As `REST_LIMIT_S`, while a lost node is waited for, a pause is noted, or the robot is shut
# down, of each step; roslaunch kills a node that has not ended 15 s after Ctrl-C [s].
SHORT_LIMIT_S = 2.5
# Storing what waits and closing a survey that ends early take less, or a lost storage comes back
# within `return_limit_s` [s].
STORING_LIMIT_S = 300.0


@dataclass(frozen=True)
class Accepted:
    """What the operator accepts when a survey is resumed.

    Attributes:
        analyzer: Identity of another analyzer; empty: none.
        zeros: Whether nothing needs to prove the zeros of the axes.
    """

    analyzer: str = ""
    zeros: bool = False


NOTHING = Accepted()
STOP = Message("Stopped on request").with_fault(STOPPED)
SHUT_DOWN = Message(
    "Interrupted: the robot is shut down. Start it again, then resume the survey."
).with_fault(STOPPED)


class Survey:
    """One survey; `run` is the body of its thread. Its parts are attributes, for each other.

    Attributes:
        interruption: What ends its waits.
        waits: Shows what takes longer than expected.
        report: What is stored about it beside its traces; analyzers and zeros are parts of that.
        pause_requested: Set when it pauses before the next point.
    """

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        status: SurveyStatus,
        interruption: Interruption,
        accepted: Accepted = NOTHING,
    ) -> None:
        """Begin a survey, or continue one from its folder; nothing happens before `run`."""
        self.plan, self.robot = plan, robot
        self.status, self.interruption, self.clock = status, interruption, interruption.clock
        self.positioner = Positioner(robot.axes, plan.config.axes, interruption, robot.workers)
        self.waits = WaitStatus(status, interruption)
        self.coverage = Coverage(
            plan.total_points,
            plan.reopened.stored_indices,
            lambda present: status.on_coverage(present, plan.survey_id),
        )
        self.report = SurveyReport(self.coverage, plan.config.axes, plan.reopened.report_json)
        self.analyzers, self.zeros = self.report.analyzers, self.report.zeros
        self.clock_steps = ClockSteps(self.clock, plan.last, self._note_clock)
        self.archive = SurveyArchive(self)
        self._steps = SurveySteps(self)
        self.pause_requested = threading.Event()
        self._resume = threading.Event()
        self._lock = threading.Lock()
        self._refusal: Optional[OtherAnalyzerError] = None
        self._recoveries = self._stored_before = 0
        self._accept(accepted)

    def run(self) -> None:
        """Execute the survey; it always ends in a final state with a message."""
        try:
            self._run()
        finally:
            self.analyzers.checked.set()
            self.archive.queue.close()
            self.positioner.release()

    def resume(self, accepted: Accepted) -> None:
        """Continue after a pause; the caller has changed the state."""
        with self._lock:
            self._accept(accepted)
            self.analyzers.checked.clear()
            self._refusal = None
            self._resume.set()

    def refusal(self, limit_s: float) -> Optional[OtherAnalyzerError]:
        """Wait until the analyzer is known [s]; return why it is refused, None if it is not."""
        self.clock.wait_s(self.analyzers.checked, limit_s)
        return self._refusal

    def show_warning(self, warning: Message) -> None:
        """Note a warning and show it until the next survey begins."""
        self.report.note_warning(warning)
        self.status.update(warning=warning)

    def _note_clock(self, warning: Message) -> None:
        self.archive.add_message(Kind.CLOCK, warning)
        self.show_warning(warning)

    def _accept(self, accepted: Accepted) -> None:
        self.analyzers.accept, self.zeros.accept = accepted.analyzer, accepted.zeros
        if accepted != NOTHING:
            self.archive.add_fact(Kind.DECISION, **asdict(accepted))

    def _run(self) -> None:
        try:
            self.status.on_coverage(self.coverage, self.plan.survey_id)
            while not self._continue():
                pass
        except ShutDownRequested:
            self._end_early(SurveyState.STOPPED, SHUT_DOWN, leaving=True)
            # The analyzer's driver is shut down too, and releases it.
            return
        except StopRequested:
            self._end_early(SurveyState.STOPPED, STOP)
        except Exception as error:
            self._end_early(SurveyState.FAILED, message_of(error))
            if not isinstance(error, DeviceError):
                log_fault("survey")
        # Without waiting: an analyzer that does not answer has no front panel either.
        self.robot.analyzer_calls.begin(self.robot.analyzer.release)

    def _continue(self) -> bool:
        """Execute the remaining steps; return False if the survey was interrupted."""
        try:
            if self._steps.run():
                self.archive.wait_until_left(0, self.plan.points[-1])
                self._close_finished(self.interruption.check)
                return True
            self._wait_paused(
                Message("Paused on request. Resume the survey, or stop it.").with_fault(STOPPED)
            )
        except DeviceError as error:
            # A stop makes parts fail too; that is no reason to pause.
            self.interruption.check_stop()
            check = self.interruption.check
            if isinstance(error, NodeLostError):
                check = self.interruption.time_limit(SHORT_LIMIT_S, error, stops=True)
            self._steps.resolve_unconfirmed(check)
            self._recover_or_pause(error)
        # What is left of a survey that is measured is to close it.
        return not self._steps.progress.visit_due and self._closed_if_stored(
            self.interruption.check
        )

    def _recover_or_pause(self, error: DeviceError) -> None:
        """Return when the survey can continue: because a node is back, or it was resumed."""
        lost: Optional[Message] = error.message
        if not isinstance(error, NodeLostError):
            # A service fails before its node is known to be lost.
            self.robot.nodes.refresh()
            lost = self.robot.nodes.lost()
        if lost is not None and not self.pause_requested.is_set():
            # Nobody knows the analyzer before its node is back.
            self.analyzers.checked.set()
            try:
                self._wait_for_return(lost)
                return
            except NodeLostError as not_back:
                error = not_back
        if not self.archive.folder:
            raise DeviceError(error.message) from error
        self.positioner.stop()
        paused = Message(
            "Paused: {reason}. Fix the fault and resume, or stop.", reason=error.message
        )
        self._wait_paused(paused, error)

    def _wait_paused(self, message: Message, error: Optional[DeviceError] = None) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        paused_s = self.clock.now_s()
        self.pause_requested.clear()
        # A request that sees the new state waits until all of this is done.
        with self._lock:
            self._resume.clear()
            self.status.enter(SurveyState.PAUSED, message)
            self.archive.add_message(Kind.PAUSE, message)
            self._refusal = error if isinstance(error, OtherAnalyzerError) else None
            self.analyzers.checked.set()
        # A storage that does not answer gets them later.
        with contextlib.suppress(DeviceError):
            self.archive.send_facts(self._storage_limit(SHORT_LIMIT_S, stops=True))
        while not self._resume.is_set():
            self.interruption.check_stop()
            self.clock_steps.check()
            self.clock.wait_s(self._resume, POLL_S)
        self.archive.add_fact(Kind.CONTINUE)
        self._recoveries = 0
        self._steps.progress.note_pause(self.clock.now_s() - paused_s)

    def _wait_for_return(self, lost: Message) -> None:
        """Stop all motion and return when all nodes answer.

        A NodeLostError says that they do not come back, or are lost repeatedly.
        """
        self.positioner.stop()
        waiting = Message(
            "Waiting: {reason}. The survey continues by itself when every part answers.",
            reason=lost,
        ).reporting_only(self.positioner.lost_fault.as_warning())
        self.status.enter(SurveyState.CHECKING, waiting)
        self.positioner.wait_for_rest(REST_LIMIT_S)
        self._count_recovery(lost)
        limit_s = self.plan.settings.return_limit_s
        check = self.interruption.time_limit(
            limit_s,
            NodeLostError(
                Message(
                    "{reason}; no answer within {limit_s:g} s; check its power and its cables; "
                    "if it stays red, switch the robot off and on",
                    reason=lost,
                    limit_s=limit_s,
                ).reporting_only(PART_RED)
            ),
            stops=True,
        )
        while self.robot.nodes.missing():
            check()
            self.clock.wait_s(self.interruption.stop, POLL_S)

    def _count_recovery(self, lost: Message) -> None:
        stored = self.status.status.visited_points
        if stored != self._stored_before:
            self._recoveries, self._stored_before = 0, stored
        if self._recoveries >= MOST_RECOVERIES:
            raise NodeLostError(
                Message(
                    "{reason}; this happened {count} times without a stored trace in between",
                    reason=lost,
                    count=MOST_RECOVERIES + 1,
                ).reporting_only(INTERNAL)
            )
        self._recoveries += 1

    def _close_finished(self, check: Check) -> None:
        """Close the survey, all traces of which are stored, unless the storage fails."""
        self.clock_steps.check()
        verdict = self.coverage.verdict()
        reason = verdict.message
        stored, total = self.archive.send_report(check, ended=True), self.plan.total_points
        if verdict.complete and stored == total:
            state = SurveyState.FINISHED
            self.status.update(visited_points=stored, remaining_s=0.0)
            message = Message("Finished, {verdict}", verdict=reason, details=self.archive.folder)
        else:
            state = SurveyState.FAILED
            message = Message(
                "Failed: the survey's folder holds {stored} of {total} traces; {verdict}",
                stored=stored,
                total=total,
                verdict=reason,
            ).with_fault(CAN_RESUME)
            reason = reason.with_fault(CAN_RESUME)
        self._close(state, state.name.lower(), message, reason, check)

    def _closed_if_stored(self, check: Check) -> bool:
        """Close the survey if every trace is stored; return whether that was possible.

        A storage that died while it closed the survey may have closed it; such a survey cannot
        be reopened.
        """
        if not self._steps.progress.all_confirmed or self.archive.queue.waiting:
            return False
        try:
            self._close_finished(check)
        except DeviceError as error:
            message = Message("The survey is not closed yet: {reason}", reason=error.message)
            self.status.update(message=message.as_warning())
            return False
        return True

    def _close(
        self, state: SurveyState, outcome: str, message: Message, reason: Message, check: Check
    ) -> None:
        """Close the survey in the storage with the status in which it ends, then enter that."""
        ended_us = self.clock.time_of_day_us()
        status = self.status.status.entered(state, message, ended_us)
        self.archive.close(outcome, reason, status, check)
        self.status.enter(state, message, ended_us)

    def _end_early(self, state: SurveyState, reason: Message, leaving: bool = False) -> None:
        """End the survey early; a failure of one action here must not prevent the next.

        When `leaving`, because the main control ends, it is interrupted, unless it is complete.
        """
        limit_s = SHORT_LIMIT_S if leaving else REST_LIMIT_S
        self.positioner.stop()
        if state is SurveyState.STOPPED:
            stopping = Message("Stopping: storing the measured traces")
            self.status.enter(SurveyState.STOPPING, stopping)
        is_stopped, moving = state is SurveyState.STOPPED, self.positioner.wait_for_rest(limit_s)
        message = reason if is_stopped else Message("Failed: {reason}", reason=reason)
        # The axes' drivers are shut down too, and stop them; their last reading may be older.
        messages = [message] if leaving or moving is None else [message, moving]
        silent = Message(
            "the VNA did not answer within {limit_s:g} s at the survey's end", limit_s=limit_s
        )
        self._steps.resolve_unconfirmed(
            self.interruption.time_limit(limit_s, DeviceError(silent, fault=VNA_SILENT))
        )
        storing_limit_s = max(STORING_LIMIT_S, self.plan.settings.return_limit_s)
        check = self._storage_limit(limit_s if leaving else storing_limit_s)
        if leaving and self._closed_if_stored(check):
            return
        try:
            if self.archive.folder:
                count = self._store_early(check, reopen=not leaving)
                outcome = INTERRUPTED if leaving else state.name.lower()
                self._close(state, outcome, in_a_row([*messages, count]), reason, check)
                return
        except Exception as error:
            # Faults in the software too: the survey must not remain STOPPING for ever.
            unfinished = Message(
                "the recordings could not be finished: {reason}", reason=message_of(error)
            ).with_fault(CAN_RESUME)
            # A storage that is shut down too closes the survey itself.
            messages += [] if leaving else [unfinished]
        self.status.enter(state, in_a_row(messages))

    def _store_early(self, check: Check, reopen: bool) -> Message:
        """Store what is measured; return how many traces are stored."""
        self.clock_steps.check()
        if reopen and self.robot.nodes.lost() is not None:
            # The storage may be one of them, and may have no open survey.
            self.archive.reopen(check)
        self.archive.queue.retry()
        self.archive.queue.wait_until_left(0, check)
        return Message(
            "{stored} of {total} traces are stored",
            stored=self.archive.send_report(check, ended=True),
            total=self.plan.total_points,
            details=self.archive.folder,
        )

    def _storage_limit(self, limit_s: float, stops: bool = False) -> Check:
        late = Message(
            "the storage did not answer within {limit_s:g} s; check it and its disk",
            limit_s=limit_s,
        )
        return self.interruption.time_limit(limit_s, DeviceError(late, fault=DISK_REFUSES), stops)
