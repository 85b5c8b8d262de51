"""The end of a survey, whatever it ends with."""

from __future__ import annotations

from typing import Callable, List

from gpr20_common.message import Message, in_a_row
from gpr20_main_control.errors import DeviceError, NodeLostError, message_of
from gpr20_main_control.mid.survey.recovery import REST_LIMIT_S, Recovery
from gpr20_main_control.mid.survey.running_survey import RunningSurvey
from gpr20_main_control.mid.survey.survey_archive import SurveyArchive
from gpr20_main_control.mid.waits import Check
from gpr20_survey.faults import CAN_RESUME, STOPPED, VNA_SILENT
from gpr20_survey.plan.survey_state import SurveyState

# Time to store the traces that wait for the disk when a survey is stopped [s].
STOPPING_LIMIT_S = 60.0
# Time to confirm the last sweep when a survey ends early [s]; then it is measured again later.
CONFIRMING_LIMIT_S = 5.0
# Steps of a shutdown; roslaunch kills a node that has not ended 15 s after Ctrl-C [s].
LEAVING_LIMIT_S = 2.5
LEAVING_CONFIRMING_LIMIT_S = 1.5
# The next survey waits for the thread of this one, and must not be kept waiting [s].
RELEASE_LIMIT_S = 5.0


class SurveyEnding:
    """Ends one survey: all axes at rest, everything that was measured stored, a last status."""

    def __init__(self, survey: RunningSurvey, archive: SurveyArchive, recovery: Recovery) -> None:
        self._survey = survey
        self._status, self._positioner = survey.status, survey.positioner
        self._archive = archive
        self._recovery = recovery

    def close_finished(self, check: Check) -> None:
        """Close the survey, all traces of which are stored.

        Raises:
            DeviceError: The storage failed.
        """
        self._survey.clock_steps.check()
        verdict = self._survey.coverage.verdict()
        stored, total = self._archive.send_last_report(check), self._survey.plan.total_points
        if verdict.complete and stored == total:
            state, outcome = SurveyState.FINISHED, "finished"
            self._status.set_progress(stored, 0.0)
            message = Message(
                "Finished, {verdict}", verdict=verdict.message, details=self._archive.folder
            )
        else:
            state, outcome = SurveyState.FAILED, "failed"
            message = Message(
                "Failed: the survey's folder holds {stored} of {total} traces; {verdict}",
                stored=stored,
                total=total,
                verdict=verdict.message,
            ).with_fault(CAN_RESUME)
        self._archive.close(outcome, verdict.message, state, message, check)
        self._status.enter(state, message)

    def finish_now(self, check: Check) -> bool:
        """Close the survey, all traces of which are stored; return whether that was possible.

        A storage that died while it closed the survey may have closed it; such a survey cannot
        be reopened.
        """
        try:
            self.close_finished(check)
        except DeviceError as error:
            self._status.set_message(
                Message("The survey is not closed yet: {reason}", reason=error.message).as_warning()
            )
            return False
        return True

    def leave(self, all_stored: Callable[[], bool], resolve: Callable[[Check], None]) -> None:
        """Leave the survey, because the main control ends: interrupted, unless it is complete.

        Args:
            all_stored: Returns whether every trace is stored.
            resolve: Confirms the last sweep, or gives it up when the check fails.
        """
        self._archive.stop_timing()
        self._positioner.stop()
        resolve(self._analyzer_limit(LEAVING_CONFIRMING_LIMIT_S))
        if all_stored() and self.finish_now(self._leaving_limit()):
            return
        message = Message(
            "Interrupted: the robot is shut down. Start it again, then resume the survey."
        ).with_fault(STOPPED)
        self._status.enter(SurveyState.STOPPING, message)
        self._positioner.wait_for_rest(LEAVING_LIMIT_S)
        if self._archive.folder:
            self._archive.interrupt(message, self._leaving_limit())
        self._status.enter(SurveyState.STOPPED, message)

    def end_early(
        self,
        state: SurveyState,
        outcome: str,
        message: Message,
        reason: Message,
        resolve: Callable[[Check], None],
    ) -> None:
        """End the survey early; a failure of one action here must not prevent the next.

        Args:
            state: The state that it ends in.
            outcome: One word, for survey.json.
            message: What the status says.
            reason: Why it ended.
            resolve: Confirms the last sweep, or gives it up when the check fails.
        """
        self._archive.stop_timing()
        self._positioner.stop()
        if state is SurveyState.STOPPED:
            stopping = Message("Stopping: storing the measured traces")
            self._status.enter(SurveyState.STOPPING, stopping)
        messages = [message]
        moving = self._positioner.wait_for_rest(REST_LIMIT_S)
        if moving is not None:
            messages.append(moving)
        resolve(self._analyzer_limit(CONFIRMING_LIMIT_S))
        ended = in_a_row(messages)
        if self._archive.folder:
            ended = self._close_early(state, outcome, messages, reason)
        self._status.enter(state, ended)

    def release_analyzer(self) -> None:
        """Leave the analyzer to its front panel; never fails."""
        try:
            robot = self._survey.robot
            robot.analyzer_calls.call(robot.analyzer.release, self._analyzer_limit(RELEASE_LIMIT_S))
        except DeviceError:
            # The survey is closed, and an analyzer that does not answer has no front panel either.
            return

    def _close_early(
        self, state: SurveyState, outcome: str, messages: List[Message], reason: Message
    ) -> Message:
        """Close the survey's folder; return what the last status says."""
        self._survey.clock_steps.check()
        check = self._recovery.return_limit_check()
        try:
            if self._recovery.nodes_changed:
                # The storage may be one of them, and may have no open survey.
                self._archive.reopen(check)
            self._archive.queue.retry()
            self._archive.queue.drain_within(STOPPING_LIMIT_S)
            count = Message(
                "{stored} of {total} traces are stored",
                stored=self._archive.send_last_report(check),
                total=self._survey.plan.total_points,
                details=self._archive.folder,
            )
            message = in_a_row([*messages, count])
            self._archive.close(outcome, reason, state, message, check)
        except Exception as error:
            # Faults in the software too: the survey must not remain STOPPING for ever.
            unfinished = Message(
                "the recordings could not be finished: {reason}", reason=message_of(error)
            ).with_fault(CAN_RESUME)
            return in_a_row([*messages, unfinished])
        return message

    def _analyzer_limit(self, limit_s: float) -> Check:
        return self._survey.interruption.time_limit(
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
        return self._survey.interruption.time_limit(
            LEAVING_LIMIT_S,
            NodeLostError(Message("the storage did not answer while it was shut down")),
        )
