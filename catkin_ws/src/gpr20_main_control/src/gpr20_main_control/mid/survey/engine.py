"""The engine runs one survey through its steps, interruptions and pauses to its end."""

from __future__ import annotations

import contextlib
import threading
from dataclasses import asdict, dataclass
from typing import Optional

from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message
from gpr20_main_control.errors import (
    DeviceError,
    NodeLostError,
    OtherAnalyzerError,
    ShutDownRequested,
    StopRequested,
    message_of,
)
from gpr20_main_control.mid.devices.instruments import Instruments
from gpr20_main_control.mid.survey import survey_steps as steps
from gpr20_main_control.mid.survey.recovery import Recovery
from gpr20_main_control.mid.survey.running_survey import RunningSurvey
from gpr20_main_control.mid.survey.sampling import Sampling
from gpr20_main_control.mid.survey.step_actions import StepActions
from gpr20_main_control.mid.survey.survey_archive import SurveyArchive
from gpr20_main_control.mid.survey.survey_ending import SurveyEnding
from gpr20_main_control.mid.waits import Check
from gpr20_survey.faults import STOPPED
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState

# Time to confirm the last sweep while a lost node is waited for [s]; then it is measured again.
CONFIRMING_LIMIT_S = 3.0
# Time to store a note on a pause [s].
NOTES_LIMIT_S = 3.0
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


class SurveyEngine:
    """Executes one survey. `run` is the body of its thread."""

    def __init__(self, survey: RunningSurvey, accepted: Accepted = NOTHING) -> None:
        """Prepare the execution of a survey; nothing happens before `run`.

        Args:
            survey: What is measured, and with what.
            accepted: With what the operator continues it.
        """
        self._survey = survey
        self._status, self._interruption = survey.status, survey.interruption
        self._analyzers, self._progress = survey.analyzers, survey.progress
        self._accept(accepted)
        archive, recovery = SurveyArchive(survey), Recovery(survey)
        ending, instruments = SurveyEnding(survey, archive, recovery), Instruments(survey)
        sampling = Sampling(survey, instruments)
        self._archive, self._recovery, self._ending = archive, recovery, ending
        self._actions = StepActions(survey, instruments, sampling, archive, recovery, ending)
        self._pause_requested = threading.Event()
        self._resume = threading.Event()
        self._lock = threading.Lock()
        self._refusal: Optional[OtherAnalyzerError] = None

    def run(self) -> None:
        """Execute the survey; it always ends in a final state with a message."""
        difference = self._survey.robot.description.software_difference()
        if difference is not None:
            self._survey.show_warning(difference)
        try:
            self._run()
        finally:
            self._analyzers.checked.set()
            self._archive.queue.close()
            self._survey.leases.release()

    def pause(self) -> None:
        """Pause after the present trace."""
        self._pause_requested.set()

    def resume(self, accepted: Accepted) -> None:
        """Continue after a pause; the caller has changed the state.

        Args:
            accepted: With what the operator continues.
        """
        with self._lock:
            self._accept(accepted)
            self._analyzers.checked.clear()
            self._refusal = None
            self._resume.set()

    def _accept(self, accepted: Accepted) -> None:
        self._analyzers.accept, self._survey.zeros.accept = accepted.analyzer, accepted.zeros
        if accepted != NOTHING:
            self._survey.notes.add(Kind.DECISION, **asdict(accepted))

    def refusal(self, limit_s: float) -> Optional[OtherAnalyzerError]:
        """Wait until the analyzer is known; return why it is refused, None if it is not.

        Args:
            limit_s: How long to wait [s]; an analyzer that is not known by then is not refused.
        """
        self._survey.clock.wait_s(self._analyzers.checked, limit_s)
        return self._refusal

    def _run(self) -> None:
        try:
            self._status.show_coverage(self._survey.coverage)
            while not self._continue():
                pass
        except ShutDownRequested:
            # The analyzer's driver is shut down too, and releases it.
            self._ending.leave(lambda: self._all_stored, self._actions.resolve_unconfirmed)
            return
        except StopRequested:
            stopped = Message("Stopped on request").with_fault(STOPPED)
            self._end_early(SurveyState.STOPPED, "stopped", stopped, stopped)
        except Exception as error:
            reason = message_of(error)
            failed = Message("Failed: {reason}", reason=reason)
            self._end_early(SurveyState.FAILED, "failed", failed, reason)
            if not isinstance(error, DeviceError):
                log_fault("survey")
        self._ending.release_analyzer()

    def _continue(self) -> bool:
        """Execute the remaining steps; return False if the survey was interrupted."""
        try:
            if self._execute_steps():
                return True
            self._wait_paused(
                Message("Paused on request. Resume the survey, or stop it.").with_fault(STOPPED)
            )
        except DeviceError as error:
            # A stop makes parts fail too; that is no reason to pause.
            self._interruption.check_stop()
            self._actions.resolve_unconfirmed(self._resolving_check(error))
            self._recover_or_pause(error)
        if not self._all_stored or self._progress.visit is not None:
            return False
        return self._ending.finish_now(self._interruption.check)

    def _execute_steps(self) -> bool:
        """Execute the steps to the end; return False if a pause was requested on the way."""
        for step in steps.survey_steps(self._survey.plan, self._progress):
            if not isinstance(step, steps.Checkpoint):
                self._actions.execute(step)
            elif self._pause_requested.is_set():
                if self._progress.unconfirmed is not None:
                    self._actions.execute(steps.Confirm(self._progress.unconfirmed))
                return False
        return True

    def _resolving_check(self, error: DeviceError) -> Check:
        """Return what ends the wait for the confirmation of the last sweep after an error."""
        if not isinstance(error, NodeLostError):
            return self._interruption.check
        limit = self._interruption.time_limit(CONFIRMING_LIMIT_S, error)

        def check() -> None:
            self._interruption.check_stop()
            limit()

        return check

    @property
    def _all_stored(self) -> bool:
        return self._progress.all_confirmed and not self._archive.queue.waiting

    def _end_early(
        self, state: SurveyState, outcome: str, message: Message, reason: Message
    ) -> None:
        self._ending.end_early(state, outcome, message, reason, self._actions.resolve_unconfirmed)

    def _recover_or_pause(self, error: DeviceError) -> None:
        """Return when the survey can continue: because a node is back, or it was resumed."""
        reason = error.message
        self._archive.stop_timing()
        lost = self._recovery.loss_behind(error)
        if lost is not None and not self._pause_requested.is_set():
            # Nobody knows the analyzer before its node is back.
            self._analyzers.checked.set()
            try:
                self._recovery.wait_for_return(lost)
                return
            except NodeLostError as not_back:
                reason = not_back.message
        if not self._archive.folder:
            raise DeviceError(reason) from error
        self._survey.positioner.stop()
        if self._pause_requested.is_set():
            paused = Message(
                "Paused on request, and a part failed: {reason}. Fix the fault and resume, or "
                "stop.",
                reason=reason,
            )
        else:
            paused = Message("Paused: {reason}. Fix the fault and resume, or stop.", reason=reason)
        self._wait_paused(paused, error)

    def _send_notes(self) -> None:
        """Store the notes that wait; a storage that does not answer gets them later."""
        limit = self._interruption.time_limit(
            NOTES_LIMIT_S, NodeLostError(Message("the storage did not answer"))
        )

        def check() -> None:
            self._interruption.check_stop()
            limit()

        with contextlib.suppress(DeviceError):
            self._archive.send_notes(check)

    def _wait_paused(self, message: Message, error: Optional[DeviceError] = None) -> None:
        """Wait, paused, until the survey is resumed or stopped."""
        self._archive.stop_timing()
        paused_s = self._survey.clock.now_s()
        self._pause_requested.clear()
        # A request that sees the new state waits until all of this is done.
        with self._lock:
            self._resume.clear()
            self._status.enter(SurveyState.PAUSED, message)
            self._survey.notes.add_message(Kind.PAUSE, message)
            self._refusal = error if isinstance(error, OtherAnalyzerError) else None
            self._analyzers.checked.set()
        self._send_notes()
        while not self._resume.is_set():
            self._interruption.check_stop()
            self._survey.clock_steps.check()
            self._survey.clock.wait_s(self._resume, POLL_S)
        self._survey.notes.add(Kind.CONTINUE)
        self._recovery.note_resumed()
        plan = self._survey.plan
        interval_s = plan.settings.reference_interval_s / plan.config.time_scale
        if self._survey.clock.now_s() - paused_s >= interval_s:
            self._progress.note_long_pause()
