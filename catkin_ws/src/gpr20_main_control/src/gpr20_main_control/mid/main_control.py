"""The control's answers to requests: parameters, start, stop, resume."""

from __future__ import annotations

import contextlib
import threading
import uuid
from dataclasses import dataclass, replace
from typing import Callable, Iterator, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.background import DeviceTurns
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import interruption_remark
from gpr20_main_control.mid.resumption import resumable_parameters
from gpr20_main_control.mid.robot import ReopenedSurvey
from gpr20_main_control.mid.survey_factory import Surroundings, SurveyFactory
from gpr20_main_control.mid.survey_plan import SurveyPlan
from gpr20_main_control.mid.survey_run import SurveyRun
from gpr20_survey.plan.survey_parameters import SurveyParameters, check
from gpr20_survey.plan.survey_state import SurveyState

# A request waits so long for another one that is still being carried out [s].
REQUEST_LIMIT_S = 5.0
# The thread of a survey ends at once when its last state was entered [s].
ENDING_LIMIT_S = 10.0


@dataclass(frozen=True)
class SurveyEstimate:
    """What a survey will be before it starts."""

    total_points: int
    duration_s: float


class MainControl:
    """Checks requests against the state and runs one survey at a time."""

    def __init__(
        self, surroundings: Surroundings, on_parameters: Callable[[SurveyParameters], None]
    ) -> None:
        """Begin idle.

        Args:
            surroundings: What every survey works with.
            on_parameters: Told the parameters of the next or present survey when they change.
        """
        self._robot = surroundings.robot
        self._facts = surroundings.facts
        self._board = surroundings.board
        self._on_parameters = on_parameters
        self._requests = threading.Lock()
        self._parameters: Optional[SurveyParameters] = None
        self._stop = threading.Event()
        self._run: Optional[SurveyRun] = None
        self._thread: Optional[threading.Thread] = None
        interruption = Interruption(self._stop, surroundings.nodes.check)
        self._positioner = Positioner(
            self._robot.axes(), self._facts.axes, interruption, surroundings.clock
        )
        # Of all surveys: a call that one has given up must not disturb the next.
        self._turns = DeviceTurns()
        self._factory = SurveyFactory(surroundings, self._positioner, interruption, self._turns)

    def set_parameters(self, parameters: SurveyParameters) -> SurveyEstimate:
        """Check the parameters and keep them for the next survey; nothing moves.

        Raises:
            RequestRefusedError: A survey is running.
            SurveyParametersError: Parameters are not allowed; each is named.
        """
        with self._one_at_a_time():
            self._refuse_while_running("the parameters cannot be changed")
            check(parameters, self._facts.travel)
            plan = self._factory.plan(parameters, "")
            self._keep(parameters)
            self._board.enter(SurveyState.CONFIGURED, f"ready for {len(plan.points)} traces")
            return SurveyEstimate(len(plan.points), sum(plan.durations_s))

    def start(self) -> str:
        """Start a survey with the parameters set before and return its id.

        Raises:
            RequestRefusedError: A survey is running, or no parameters have been set.
        """
        with self._one_at_a_time():
            self._refuse_while_running("another survey cannot start")
            if self._parameters is None:
                raise RequestRefusedError("no parameters have been set; set them, then start")
            plan = self._factory.plan(self._parameters, str(uuid.uuid4()))
            self._begin(plan, self._parameters, None)
            return plan.survey_id

    def pause(self) -> str:
        """Hold the survey after the sample that is being measured.

        Raises:
            RequestRefusedError: No survey is measuring now.
        """
        with self._one_at_a_time():
            status = self._board.status
            if status.state is not SurveyState.SURVEYING or self._run is None:
                raise RequestRefusedError(
                    f"no survey is measuring (the control is {status.state.name}); there is "
                    "nothing to pause"
                )
            self._board.enter(SurveyState.PAUSING, "pausing after this sample")
            self._run.pause()
            return "pausing; control_status says PAUSED when the present sample is taken"

    def stop(self) -> str:
        """Stop the survey now; returns while the axes are still slowing down.

        Raises:
            RequestRefusedError: No survey is running.
        """
        # No lock: a stop waits for nobody.
        if not self._board.status.state.running:
            raise RequestRefusedError("no survey is running; there is nothing to stop")
        self._stop.set()
        self._positioner.stop()
        return "stopping; control_status says STOPPED when everything stands still and is stored"

    def resume(self, survey: str) -> str:
        """Go on with the paused survey, or with one that was cut off or ended early.

        Args:
            survey: Empty for the paused one; else a survey's id or the name of its folder.

        Raises:
            RequestRefusedError: There is nothing to resume, or not on this robot.
            DeviceError: The survey could not be opened again.
        """
        with self._one_at_a_time():
            status = self._board.status
            if status.state is SurveyState.PAUSED and self._run is not None:
                folder_end = f"_{status.survey_id[:8]}"
                if survey not in ("", status.survey_id) and not survey.endswith(folder_end):
                    raise RequestRefusedError(
                        f"the paused survey is {status.survey_id}, not {survey[:64]!r}; stop it "
                        "first"
                    )
                # Here, so that nobody sees it paused who was told that it goes on.
                self._board.enter(SurveyState.CHECKING, "checking the robot before going on")
                self._run.resume()
                return "resuming"
            self._refuse_while_running("another survey cannot be resumed")
            if not survey:
                raise RequestRefusedError(
                    f"no survey is paused (the control is {status.state.name}); name the survey "
                    "that shall go on"
                )
            return self._resume_from_disk(survey)

    def shut_down(self, time_limit_s: float) -> None:
        """Stop a running survey and wait for its end."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(time_limit_s)

    @contextlib.contextmanager
    def _one_at_a_time(self) -> Iterator[None]:
        if not self._requests.acquire(timeout=REQUEST_LIMIT_S):
            raise RequestRefusedError(
                f"another request is still being carried out after {REQUEST_LIMIT_S:g} s "
                "(opening a large survey again takes long); ask again when it has ended"
            )
        try:
            yield
        finally:
            self._requests.release()

    def _keep(self, parameters: SurveyParameters) -> None:
        self._parameters = parameters
        self._on_parameters(parameters)

    def _refuse_while_running(self, consequence: str) -> None:
        state = self._board.status.state
        if state.running:
            raise RequestRefusedError(
                f"a survey is {state.name}: {consequence}; stop it or wait for its end"
            )
        # The state is final a moment before the thread has ended.
        if self._thread is not None:
            self._thread.join(ENDING_LIMIT_S)
            if self._thread.is_alive():
                raise RequestRefusedError(
                    f"the former survey has not ended within {ENDING_LIMIT_S:g} s: "
                    f"{consequence}; try again"
                )

    def _resume_from_disk(self, survey: str) -> str:
        storage = self._robot.storage
        reopened = self._turns.storage.take(lambda: storage.reopen(survey), lambda: None)
        try:
            parameters = resumable_parameters(reopened, self._facts)
            check(parameters, self._facts.travel)
            plan = replace(
                self._factory.plan(parameters, reopened.survey_id),
                stored=frozenset(reopened.stored_indices),
                last=reopened.last,
            )
            self._begin(plan, parameters, reopened)
        except Gpr20Error as error:
            # Refused, so it must not stay open.
            storage.close(reopened.survey_id, "failed", f"not resumed: {error}")
            raise
        return (
            f"resuming with {len(plan.pending)} of {len(plan.points)} traces to go"
            f"{interruption_remark(reopened.interrupted)}"
        )

    def _begin(
        self, plan: SurveyPlan, parameters: SurveyParameters, reopened: Optional[ReopenedSurvey]
    ) -> None:
        # Before anything changes: a survey that cannot be put together is refused.
        self._run = self._factory.run(plan, parameters, reopened)
        self._keep(parameters)
        self._stop.clear()
        self._board.begin_survey(
            plan.survey_id, len(plan.points), len(plan.stored), sum(plan.pending_durations_s)
        )
        self._board.enter(SurveyState.CHECKING, "checking the robot")
        self._thread = threading.Thread(target=self._run.run, name="survey")
        self._thread.start()
