"""The control's answers to requests: parameters, start, stop, resume."""

from __future__ import annotations

import contextlib
import threading
import uuid
from dataclasses import replace
from typing import Iterator, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.engine import SurveyEngine
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.robot import Robot
from gpr20_main_control.mid.survey_archive import interruption_remark
from gpr20_main_control.mid.survey_plan import SurveyPlan, plan_resumption, plan_survey
from gpr20_main_control.mid.survey_status import SurveyStatus
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState

# A request waits so long for another one that is still being carried out [s].
REQUEST_LIMIT_S = 5.0
# The thread of a survey ends at once when its last state was entered [s].
ENDING_LIMIT_S = 10.0


class MainControl:
    """Checks requests against the state and runs one survey at a time."""

    def __init__(
        self,
        robot: Robot,
        config: RobotConfig,
        settings: SurveySettings,
        status: SurveyStatus,
        clock: Clock,
    ) -> None:
        self._robot = robot
        self._config = config
        self._settings = settings
        self._status = status
        self._interruption = Interruption(robot.nodes, clock)
        self._positioner = Positioner(robot.axes, config.axes, self._interruption)
        self._requests = threading.Lock()
        self._plan: Optional[SurveyPlan] = None
        self._engine: Optional[SurveyEngine] = None
        self._thread: Optional[threading.Thread] = None

    def set_parameters(self, parameters: SurveyParameters) -> SurveyPlan:
        """Check the parameters and plan the next survey; nothing moves.

        Raises:
            RequestRefusedError: A survey is running.
            SurveyParametersError: Parameters are not allowed; each is named.
        """
        with self._one_at_a_time():
            self._refuse_while_running("the parameters cannot be changed")
            self._plan = plan_survey(parameters, self._config, self._settings)
            self._status.show_parameters(parameters)
            message = f"ready for {self._plan.total_points} traces"
            self._status.enter(SurveyState.CONFIGURED, message)
            return self._plan

    def start(self) -> str:
        """Start a survey with the parameters set before and return its id.

        Raises:
            RequestRefusedError: A survey is running, or no parameters have been set.
        """
        with self._one_at_a_time():
            self._refuse_while_running("another survey cannot start")
            if self._plan is None:
                raise RequestRefusedError("no parameters have been set; set them, then start")
            plan = replace(self._plan, survey_id=str(uuid.uuid4()), reopened=None)
            self._begin(plan)
            return plan.survey_id

    def pause(self) -> str:
        """Hold the survey after the sample that is being measured.

        Raises:
            RequestRefusedError: No survey is measuring now.
        """
        with self._one_at_a_time():
            status = self._status.status
            if status.state is not SurveyState.SURVEYING or self._engine is None:
                raise RequestRefusedError(
                    f"no survey is measuring (the control is {status.state.name}); there is "
                    "nothing to pause"
                )
            self._status.enter(SurveyState.PAUSING, "pausing after this sample")
            self._engine.pause()
            return "pausing; control_status says PAUSED when the present sample is taken"

    def stop(self) -> str:
        """Stop the survey now; returns while the axes are still slowing down.

        Raises:
            RequestRefusedError: No survey is running.
        """
        # No lock: a stop waits for nobody.
        if not self._status.status.state.running:
            raise RequestRefusedError("no survey is running; there is nothing to stop")
        self._interruption.stop.set()
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
            status = self._status.status
            if status.state is SurveyState.PAUSED and self._engine is not None:
                folder_end = f"_{status.survey_id[:8]}"
                if survey not in ("", status.survey_id) and not survey.endswith(folder_end):
                    raise RequestRefusedError(
                        f"the paused survey is {status.survey_id}, not {survey[:64]!r}; stop it "
                        "first"
                    )
                # Here, so that nobody sees it paused after the answer that it continues.
                self._status.enter(SurveyState.CHECKING, "checking the robot before going on")
                self._engine.resume()
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
        self._interruption.stop.set()
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

    def _refuse_while_running(self, consequence: str) -> None:
        state = self._status.status.state
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
        reopened = self._robot.storage_calls.call(lambda: storage.reopen(survey), lambda: None)
        try:
            plan = plan_resumption(reopened, self._config, self._settings)
            self._begin(plan)
        except Gpr20Error as error:
            # Refused, so it must not stay open.
            storage.close(reopened.survey_id, "failed", f"not resumed: {error}")
            raise
        return (
            f"resuming with {len(plan.pending)} of {plan.total_points} traces to go"
            f"{interruption_remark(reopened.interrupted)}"
        )

    def _begin(self, plan: SurveyPlan) -> None:
        # Before anything changes: a survey that cannot be put together is refused.
        engine = SurveyEngine(plan, self._robot, self._status, self._positioner, self._interruption)
        self._plan, self._engine = plan, engine
        self._status.show_parameters(plan.parameters)
        self._interruption.stop.clear()
        self._status.begin_survey(
            plan.survey_id,
            plan.total_points,
            len(plan.stored_indices),
            sum(plan.pending_durations_s),
        )
        self._status.enter(SurveyState.CHECKING, "checking the robot")
        self._thread = threading.Thread(target=engine.run, name="survey")
        self._thread.start()
