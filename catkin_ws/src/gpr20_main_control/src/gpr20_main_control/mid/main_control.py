"""The requests to the main control: set parameters, start, pause, stop, resume, service.

One survey, or one action of maintenance, at a time.
"""

from __future__ import annotations

import contextlib
import threading
import uuid
from dataclasses import replace
from typing import Callable, Iterator, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, BUSY, IN_USE
from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message
from gpr20_main_control.errors import STOPPED_BEFORE, RequestRefusedError
from gpr20_main_control.mid.daily_check import DailyCheck, Verdict
from gpr20_main_control.mid.devices.robot import Robot, SurveyEnd
from gpr20_main_control.mid.service import TEST_SWEEP, AxisMove, move_axis, run_analyzer_test
from gpr20_main_control.mid.survey.survey import NOTHING, Accepted, Survey
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan, plan_resumption, plan_survey
from gpr20_main_control.mid.survey.survey_status import Status, SurveyStatus
from gpr20_main_control.mid.waits import Interruption
from gpr20_survey.faults import NO_PLAN, NONE_OPEN
from gpr20_survey.folder.survey_folder import check_survey_id
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters, SurveySettings, check_address
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.answers import AnalyzerTest

# A request waits this long for another one to end [s].
REQUEST_LIMIT_S = 5.0
# Nodes that are launched together have described themselves within this time [s].
STARTING_LIMIT_S = 4.0
# A resumption waits this long to learn whether the analyzer is another one [s]; it must end
# before the next request gives up.
ANALYZER_LIMIT_S = 4.0


class MainControl:
    """Checks requests against the state and runs one survey at a time.

    A request raises RequestRefusedError if it is not possible now, InvalidValueError if a value is
    not allowed or the parts of the robot disagree, DeviceError if a part failed, StopRequested if
    it was stopped.
    """

    def __init__(
        self,
        robot: Robot,
        settings: SurveySettings,
        status: SurveyStatus,
        clock: Clock,
        defaults: Annotation = EMPTY,
        on_service: Callable[[Optional[Message]], None] = lambda _activity: None,
    ) -> None:
        """Build it; no survey runs.

        `defaults` are those of surveys that are started without, `on_service` is called with what
        is done for maintenance, and None when it has ended.
        """
        self._robot, self._settings, self._defaults = robot, settings, defaults
        self._status, self._on_service = status, on_service
        self._interruption = Interruption(clock, robot.nodes)
        # What is done for maintenance, and what ends it.
        self._service: Optional[Message] = None
        self._in_service = Interruption(clock)
        self._daily_check = DailyCheck(robot)
        self._requests = threading.Lock()
        # What was asked for before a STOP does not begin after it.
        self._stops = self._stops_at_plan = 0
        self._plan: Optional[SurveyPlan] = None
        self._survey: Optional[Survey] = None
        self._thread: Optional[threading.Thread] = None

    def set_parameters(self, parameters: SurveyParameters, set_by: str = "") -> SurveyPlan:
        """Check the parameters and plan the next survey; nothing moves."""
        stops = self._stops
        with self._one_at_a_time():
            self._refuse_while_busy(in_service=False)
            description = self._robot.description
            config = description.config(STARTING_LIMIT_S)
            address = parameters.vna_address or description.analyzer_address()
            parameters = replace(parameters, vna_address=address)
            self._plan = replace(plan_survey(parameters, config, self._settings), set_by=set_by)
            self._stops_at_plan = stops
            self._status.set_plan(self._plan)
            return self._plan

    def start(
        self,
        annotation: Annotation = EMPTY,
        refines: str = "",
        permittivity: Optional[float] = None,
        plan_id: str = "",
    ) -> str:
        """Start a survey with the parameters set before, those of `plan_id`; return its id.

        Empty fields of the annotation become the robot's defaults, an empty `plan_id` is that of
        whatever is set; the rest is as in `SurveyPlan`.
        """
        with self._one_at_a_time():
            self._refuse_while_busy()
            if self._plan is None:
                raise RequestRefusedError(
                    Message("no parameters have been set; set them, then start"), fault=NO_PLAN
                )
            self._plan.prove(plan_id)
            # Planned again: a part may have been restarted with another configuration.
            config, parameters = self._robot.description.config(), self._plan.parameters
            plan = replace(
                plan_survey(parameters, config, self._settings),
                set_by=self._plan.set_by,
                survey_id=str(uuid.uuid4()),
                annotation=annotation.with_defaults(self._defaults),
                refines=refines and check_survey_id(refines),
                permittivity=permittivity,
            )
            self._begin(plan, self._stops_at_plan)
            return plan.survey_id

    def pause(self) -> Message:
        """Pause the survey after the present trace; return what happens now."""
        with self._one_at_a_time():
            status = self._status.status
            if status.state is not SurveyState.SURVEYING or self._survey is None:
                raise RequestRefusedError(
                    Message(
                        "no survey is measuring, so none can be paused; STOP ends a survey at "
                        "any time",
                        details=status.state.name,
                    ),
                    fault=IN_USE.as_note() if status.state.running else ASKED_FOR,
                )
            pausing = Message("Pausing after the present trace")
            self._status.enter(SurveyState.PAUSING, pausing)
            self._survey.pause_requested.set()
            return pausing

    def stop(self) -> Message:
        """Stop the survey, or what is done for maintenance, now.

        Returns, with what happens now, while the axes still slow down.
        """
        # No lock: a stop does not wait for other requests. First, so that what begins meanwhile
        # either sees it or is stopped here.
        self._stops += 1
        if self._service is not None:
            self._in_service.stop.set()
            self._stop_axes()
            return Message("Stopping the axes")
        if not self._status.status.state.running:
            if self._requests.locked():
                return Message("No survey runs; what is being prepared does not begin")
            raise RequestRefusedError(
                Message("no survey is running; there is nothing to stop"), fault=ASKED_FOR
            )
        self._interruption.stop.set()
        # It was for this survey; the next one may have the same parameters.
        self._stops_at_plan = self._stops
        self._stop_axes()
        return Message("Stopping the axes, then storing the measured traces")

    def resume(self, survey: str, accepted: Accepted = NOTHING) -> Message:
        """Continue the paused survey (empty), or one on the disk, by its id or folder's name."""
        stops = self._stops
        with self._one_at_a_time():
            status = self._status.status
            if status.state is SurveyState.PAUSED and self._survey is not None:
                resuming = self._resume_paused(self._survey, survey, accepted)
            else:
                self._refuse_while_busy()
                if not survey:
                    raise RequestRefusedError(
                        Message(
                            "no survey is paused; name the survey to resume",
                            details=status.state.name,
                        ),
                        fault=NONE_OPEN,
                    )
                resuming = self._resume_from_disk(survey, accepted, stops)
            # The survey may have paused again because of its analyzer.
            assert self._survey is not None
            refusal = self._survey.refusal(ANALYZER_LIMIT_S)
            if refusal is not None:
                raise refusal
            return resuming

    def _resume_paused(self, paused_survey: Survey, survey: str, accepted: Accepted) -> Message:
        paused = self._status.status.survey_id
        if survey not in ("", paused) and not survey.endswith(f"_{paused[:8]}"):
            raise RequestRefusedError(
                Message(
                    "the paused survey is {paused}, not {requested}; resume it, or stop it first",
                    paused=paused,
                    requested=repr(survey[:64]),
                ),
                fault=IN_USE,
            )
        # Before the answer, after which the survey must no longer be shown as paused.
        checking = Message("Checking the robot before the survey continues")
        self._status.enter(SurveyState.CHECKING, checking)
        paused_survey.resume(accepted)
        return Message("Resuming")

    def move_for_service(self, move: AxisMove) -> Message:
        """Move one axis for maintenance and return, when it is at rest, where it is."""
        with self._serving(move.activity):
            return move_axis(self._robot, move, self._in_service)

    def test_analyzer(self, address: str) -> AnalyzerTest:
        """Test the analyzer at an address; empty: as the robot is configured."""
        check_address(address)
        with self._serving(Message("testing the VNA")):
            plan = self._plan
            settings = TEST_SWEEP if plan is None else plan.parameters.sweep_settings
            return run_analyzer_test(self._robot, address, settings, self._in_service)

    def daily_check(self, step: int, client: str = "") -> Optional[Verdict]:
        """Take a step of the daily check of a client; return the verdict after the last one."""
        with self._serving(Message("daily check of the radar")):
            return self._daily_check.take(step, client, self._in_service)

    @contextlib.contextmanager
    def _serving(self, activity: Message) -> Iterator[None]:
        stops = self._stops
        with self._one_at_a_time():
            self._refuse_while_busy()
            self._in_service.stop.clear()
            self._service = activity
        try:
            # From now on a STOP reaches the action.
            self._refuse_after_stop(stops)
            self._on_service(activity)
            yield
        finally:
            self._service = None
            self._on_service(None)

    def shut_down(self, time_limit_s: float) -> None:
        """Interrupt a running survey, which can be resumed, and wait until it is closed."""
        self._interruption.shut_down()
        self._in_service.shut_down()
        if self._service is not None:
            self._stop_axes()
        if self._thread is not None:
            self._thread.join(time_limit_s)

    def _stop_axes(self) -> None:
        for axis in self._robot.axes.values():
            axis.stop()

    @contextlib.contextmanager
    def _one_at_a_time(self) -> Iterator[None]:
        if not self._requests.acquire(timeout=REQUEST_LIMIT_S):
            raise _still_busy()
        try:
            yield
        finally:
            self._requests.release()

    def _refuse_while_busy(self, in_service: bool = True) -> None:
        activity = self._service if in_service else None
        if self._status.status.state.running:
            activity = Message("a survey that is running or paused")
        if activity is not None:
            raise RequestRefusedError(
                Message(
                    "the robot is in use ({activity}); wait for its end, or press STOP",
                    activity=activity,
                )
            )
        # The state is final a moment before the thread has ended.
        if self._thread is not None:
            self._thread.join(REQUEST_LIMIT_S)
            if self._thread.is_alive():
                raise _still_busy()

    def _refuse_after_stop(self, stops: int) -> None:
        if self._stops != stops:
            raise RequestRefusedError(
                Message("STOP was requested meanwhile; nothing begins"),
                fault=STOPPED_BEFORE,
            )

    def _resume_from_disk(self, survey: str, accepted: Accepted, stops: int) -> Message:
        storage = self._robot.storage
        reopened = self._robot.storage_calls.call(lambda: storage.reopen(survey), lambda: None)
        try:
            config = self._robot.description.config(STARTING_LIMIT_S)
            plan = plan_resumption(reopened, config, self._settings)
            self._begin(plan, stops, accepted)
        except Gpr20Error as error:
            # Refused, so it must not stay open.
            refusal = Message("not resumed: {reason}", reason=error.message)
            status = Status(SurveyState.CHECKING, survey_id=reopened.survey_id)
            status = status.entered(SurveyState.FAILED, refusal, time_of_day_us())
            storage.close(reopened.survey_id, SurveyEnd("failed", refusal, status))
            raise
        pending, total = len(plan.pending), plan.total_points
        return Message("Resuming; {pending} of {total} traces remain", pending=pending, total=total)

    def _begin(self, plan: SurveyPlan, stops: int, accepted: Accepted = NOTHING) -> None:
        # First, so that nothing changes if the survey is refused here.
        self._refuse_after_stop(stops)
        survey = Survey(plan, self._robot, self._status, self._interruption, accepted)
        self._plan, self._survey = plan, survey
        self._stops_at_plan = stops
        self._interruption.stop.clear()
        self._status.begin_survey(plan)
        if self._stops != stops:
            # It came after the look above, and found no survey that it could stop.
            self._interruption.stop.set()
        self._thread = threading.Thread(target=survey.run, name="survey")
        self._thread.start()


def _still_busy() -> RequestRefusedError:
    return RequestRefusedError(
        Message(
            "what was requested before did not end within {limit_s:g} s, because reopening a large "
            "survey takes long; try again later",
            limit_s=REQUEST_LIMIT_S,
        ),
        fault=BUSY,
    )
