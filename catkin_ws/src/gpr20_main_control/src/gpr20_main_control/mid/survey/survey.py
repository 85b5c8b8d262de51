"""One survey: its state, and how it is interrupted, paused, resumed and ended.

`survey_steps` says what is done at each point, `waits` what may interrupt a wait.
"""

from __future__ import annotations

import contextlib
import threading
from dataclasses import asdict, dataclass
from typing import List, Optional

from gpr20_common.faults import INTERNAL, PART_RED
from gpr20_common.low.clock import time_of_day_us
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
from gpr20_main_control.mid.survey.clock_steps import ClockSteps
from gpr20_main_control.mid.survey.survey_archive import SurveyArchive
from gpr20_main_control.mid.survey.survey_coverage import Coverage
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey.survey_report import AnalyzerRecord, SurveyReport, former_report
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_main_control.mid.survey.survey_steps import SurveySteps
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_main_control.mid.waits import Check, Interruption, WaitStatus
from gpr20_survey.faults import CAN_RESUME, STOPPED, VNA_SILENT
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.survey_state import SurveyState

# A survey that loses nodes more often than this without storing a trace in between is paused.
MOST_RECOVERIES = 3
# Axes that slow down from their top speed come to rest well within this time [s].
REST_LIMIT_S = 10.0
# Time to confirm the last sweep while a lost node is waited for, and when a survey ends early;
# then it is measured again later [s].
LOST_CONFIRMING_LIMIT_S = 3.0
CONFIRMING_LIMIT_S = 5.0
# Time to store what is noted of a pause [s].
NOTES_LIMIT_S = 3.0
# Time to store the traces that wait for the disk when a survey is stopped [s].
STOPPING_LIMIT_S = 60.0
# Steps of a shutdown; roslaunch kills a node that has not ended 15 s after Ctrl-C [s].
LEAVING_LIMIT_S = 2.5
LEAVING_CONFIRMING_LIMIT_S = 1.5
# The next survey waits for the thread of this one, and must not be kept waiting [s].
RELEASE_LIMIT_S = 5.0
POLL_S = 0.05


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


class Survey:
    """One survey; `run` is the body of its thread.

    Attributes:
        plan: What is measured.
        robot: The parts of the robot.
        status: What is shown of the survey.
        interruption: What ends its waits.
        clock: The clock of its waits.
        positioner: Its axes.
        waits: Shows what takes longer than expected.
        analyzers: With which analyzers it is measured.
        zeros: To which zeros of the axes its traces refer.
        coverage: The state of each planned sample.
        report: What is stored about it beside its traces.
        clock_steps: Notices that the computer's clock was set.
        archive: Stores it.
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
        """Begin a survey, or continue one from its folder; nothing happens before `run`.

        Raises:
            SurveyError: The report of the survey that is resumed cannot be read.
        """
        self.plan, self.robot = plan, robot
        self.status, self.interruption, self.clock = status, interruption, interruption.clock
        self.positioner = Positioner(robot.axes, plan.config.axes, interruption, robot.workers)
        self.waits = WaitStatus(status, interruption)
        former = former_report(plan.reopened)
        self.analyzers = AnalyzerRecord(former.analyzers)
        self.zeros = ZeroRecord(former.zeros, plan.config.axes)
        self.coverage = Coverage(plan.total_points, plan.stored_indices)
        self.report = SurveyReport(self.coverage, self.analyzers, self.zeros, former)
        # Set last: what was measured before is not a change.
        self.coverage.on_change = status.show_coverage
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
        difference = self.robot.description.software_difference()
        if difference is not None:
            self.show_warning(difference)
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

    def note_warning(self, warning: Message) -> None:
        """Note a warning, which is stored with the next report."""
        # The survey continues in spite of it, whatever it is.
        self.report.note_warning(warning.as_warning(), time_of_day_us())

    def show_warning(self, warning: Message) -> None:
        """Note a warning and show it until the next survey begins."""
        self.note_warning(warning)
        self.status.update(warning=warning)

    def accept_nodes(self) -> None:
        """Continue with the nodes as they are now, or raise if one does not answer."""
        self.robot.nodes.accept()
        self.robot.nodes.check()

    def _note_clock(self, warning: Message) -> None:
        self.archive.add_message(Kind.CLOCK, warning)
        self.show_warning(warning)

    def _accept(self, accepted: Accepted) -> None:
        self.analyzers.accept, self.zeros.accept = accepted.analyzer, accepted.zeros
        if accepted != NOTHING:
            self.archive.add_fact(Kind.DECISION, **asdict(accepted))

    def _run(self) -> None:
        try:
            self.status.show_coverage(self.coverage)
            while not self._continue():
                pass
        except ShutDownRequested:
            # The analyzer's driver is shut down too, and releases it.
            self._leave()
            return
        except StopRequested:
            stopped = Message("Stopped on request").with_fault(STOPPED)
            self._end_early(SurveyState.STOPPED, stopped, stopped)
        except Exception as error:
            reason = message_of(error)
            failed = Message("Failed: {reason}", reason=reason)
            self._end_early(SurveyState.FAILED, failed, reason)
            if not isinstance(error, DeviceError):
                log_fault("survey")
        # The survey is closed, and an analyzer that does not answer has no front panel either.
        with contextlib.suppress(DeviceError):
            self.robot.analyzer_calls.call(
                self.robot.analyzer.release, self._analyzer_limit(RELEASE_LIMIT_S)
            )

    def _continue(self) -> bool:
        """Execute the remaining steps; return False if the survey was interrupted."""
        try:
            if self._steps.run():
                self.archive.drain()
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
                check = self.interruption.time_limit(LOST_CONFIRMING_LIMIT_S, error, stops=True)
            self._steps.resolve_unconfirmed(check)
            self._recover_or_pause(error)
        # What is left of a survey that is measured is to close it.
        return not self._steps.progress.visit_due and self._closed_if_stored(
            self.interruption.check
        )

    def _recover_or_pause(self, error: DeviceError) -> None:
        """Return when the survey can continue: because a node is back, or it was resumed."""
        reason = error.message
        self.archive.stop_timing()
        lost = self._loss_behind(error)
        if lost is not None and not self.pause_requested.is_set():
            # Nobody knows the analyzer before its node is back.
            self.analyzers.checked.set()
            try:
                self._wait_for_return(lost)
                return
            except NodeLostError as not_back:
                reason = not_back.message
        if not self.archive.folder:
            raise DeviceError(reason) from error
        self.positioner.stop()
        if self.pause_requested.is_set():
            paused = Message(
                "Paused on request, and a part failed: {reason}. Fix the fault and resume, or "
                "stop.",
                reason=reason,
            )
        else:
            paused = Message("Paused: {reason}. Fix the fault and resume, or stop.", reason=reason)
        self._wait_paused(paused, error)

    def _wait_paused(self, message: Message, error: Optional[DeviceError] = None) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        self.archive.stop_timing()
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
        silent = NodeLostError(Message("the storage did not answer"))
        with contextlib.suppress(DeviceError):
            self.archive.send_facts(self.interruption.time_limit(NOTES_LIMIT_S, silent, stops=True))
        while not self._resume.is_set():
            self.interruption.check_stop()
            self.clock_steps.check()
            self.clock.wait_s(self._resume, POLL_S)
        self.archive.add_fact(Kind.CONTINUE)
        self._recoveries = 0
        self._steps.progress.note_pause(self.clock.now_s() - paused_s)

    def _loss_behind(self, error: DeviceError) -> Optional[Message]:
        """Return which nodes were lost if that caused an error; None otherwise."""
        if isinstance(error, NodeLostError):
            # The node may be back already.
            return error.message
        # A service fails before its node is known to be lost.
        self.robot.nodes.refresh()
        return self.robot.nodes.lost()

    def _wait_for_return(self, lost: Message) -> None:
        """Stop all motion and return when all nodes answer.

        Raises:
            NodeLostError: They do not come back, or are lost repeatedly.
            StopRequested: A stop of the survey was requested.
        """
        self.positioner.stop()
        waiting = Message(
            "Waiting: {reason}. The survey continues by itself when every part answers.",
            reason=lost,
        ).reporting_only(self.positioner.lost_fault.as_warning())
        if self.status.status.state is SurveyState.CHECKING:
            self.status.update(message=waiting)
        else:
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
        """Close the survey, all traces of which are stored.

        Raises:
            DeviceError: The storage failed.
        """
        self.clock_steps.check()
        verdict = self.coverage.verdict()
        stored, total = self.archive.send_last_report(check), self.plan.total_points
        if verdict.complete and stored == total:
            state = SurveyState.FINISHED
            self.status.update(visited_points=stored, remaining_s=0.0)
            message = Message(
                "Finished, {verdict}", verdict=verdict.message, details=self.archive.folder
            )
        else:
            state = SurveyState.FAILED
            message = Message(
                "Failed: the survey's folder holds {stored} of {total} traces; {verdict}",
                stored=stored,
                total=total,
                verdict=verdict.message,
            ).with_fault(CAN_RESUME)
        self._end(state, message, verdict.message, check)

    def _closed_if_stored(self, check: Check) -> bool:
        """Close the survey if every trace is stored; return whether that was possible.

        A storage that died while it closed the survey may have closed it; such a survey cannot
        be reopened.
        """
        if not self._steps.progress.all_confirmed or self.archive.queue.waiting:
            return False
        if self.status.status.state in (SurveyState.HOMING, SurveyState.PAUSED):
            # The way from there to the end.
            self.status.enter(SurveyState.CHECKING, Message("Checking the robot"))
        try:
            self._close_finished(check)
        except DeviceError as error:
            message = Message("The survey is not closed yet: {reason}", reason=error.message)
            self.status.update(message=message.as_warning())
            return False
        return True

    def _end(self, state: SurveyState, message: Message, reason: Message, check: Check) -> None:
        ended_us = self.clock.time_of_day_us()
        status = self.status.status.entered(state, message, ended_us)
        self.archive.close(state.name.lower(), reason, status, check)
        self.status.enter(state, message, ended_us)

    def _leave(self) -> None:
        """Leave the survey, because the main control ends: interrupted, unless it is complete."""
        self.archive.stop_timing()
        self.positioner.stop()
        self._steps.resolve_unconfirmed(self._analyzer_limit(LEAVING_CONFIRMING_LIMIT_S))
        if self._closed_if_stored(self._leaving_limit()):
            return
        message = Message(
            "Interrupted: the robot is shut down. Start it again, then resume the survey."
        ).with_fault(STOPPED)
        self.status.enter(SurveyState.STOPPING, message)
        self.positioner.wait_for_rest(LEAVING_LIMIT_S)
        ended_us = self.clock.time_of_day_us()
        if self.archive.folder:
            # The storage is shut down too, usually at the same time, and then closes it itself.
            check = self._leaving_limit()
            with contextlib.suppress(DeviceError):
                self.archive.queue.wait_until_left(0, check)
                status = self.status.status.entered(SurveyState.STOPPED, message, ended_us)
                self.archive.close(INTERRUPTED, message, status, check)
        self.status.enter(SurveyState.STOPPED, message, ended_us)

    def _end_early(self, state: SurveyState, message: Message, reason: Message) -> None:
        """End the survey early; a failure of one action here must not prevent the next."""
        self.archive.stop_timing()
        self.positioner.stop()
        if state is SurveyState.STOPPED:
            stopping = Message("Stopping: storing the measured traces")
            self.status.enter(SurveyState.STOPPING, stopping)
        messages = [message]
        moving = self.positioner.wait_for_rest(REST_LIMIT_S)
        if moving is not None:
            messages.append(moving)
        self._steps.resolve_unconfirmed(self._analyzer_limit(CONFIRMING_LIMIT_S))
        if self.archive.folder:
            try:
                self._close_early(state, messages, reason)
                return
            except Exception as error:
                # Faults in the software too: the survey must not remain STOPPING for ever.
                messages.append(
                    Message(
                        "the recordings could not be finished: {reason}", reason=message_of(error)
                    ).with_fault(CAN_RESUME)
                )
        self.status.enter(state, in_a_row(messages))

    def _close_early(self, state: SurveyState, messages: List[Message], reason: Message) -> None:
        self.clock_steps.check()
        check = self._return_limit()
        if self.robot.nodes.lost() is not None:
            # The storage may be one of them, and may have no open survey.
            self.archive.reopen(check)
        self.archive.queue.retry()
        self.archive.queue.drain_within(STOPPING_LIMIT_S)
        count = Message(
            "{stored} of {total} traces are stored",
            stored=self.archive.send_last_report(check),
            total=self.plan.total_points,
            details=self.archive.folder,
        )
        self._end(state, in_a_row([*messages, count]), reason, check)

    def _return_limit(self) -> Check:
        """Return a check that limits the wait for a storage that may be lost, at the end."""
        deadline_s = self.clock.now_s() + self.plan.settings.return_limit_s

        def check() -> None:
            if self.robot.nodes.missing() and self.clock.now_s() > deadline_s:
                self.robot.nodes.check()

        return check

    def _analyzer_limit(self, limit_s: float) -> Check:
        return self.interruption.time_limit(
            limit_s,
            DeviceError(
                Message(
                    "the VNA did not answer within {limit_s:g} s at the survey's end",
                    limit_s=limit_s,
                ),
                fault=VNA_SILENT,
            ),
        )

    def _leaving_limit(self) -> Check:
        return self.interruption.time_limit(
            LEAVING_LIMIT_S,
            NodeLostError(Message("the storage did not answer while it was shut down")),
        )
