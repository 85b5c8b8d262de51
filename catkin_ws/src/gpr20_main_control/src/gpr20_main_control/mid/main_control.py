"""The control's answers to requests: parameters, start, stop, resume."""

from __future__ import annotations

import json
import threading
import uuid
from dataclasses import asdict, dataclass, replace
from typing import Callable, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.coverage import Coverage
from gpr20_main_control.mid.measurement import PointMeasurement
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import (
    CALIBRATION_MEANINGS,
    InstrumentState,
    Preparation,
)
from gpr20_main_control.mid.resumption import resumable_parameters
from gpr20_main_control.mid.robot import ReopenedSurvey, Robot, SurveyRecord
from gpr20_main_control.mid.robot_facts import RobotFacts
from gpr20_main_control.mid.status_board import StatusBoard
from gpr20_main_control.mid.survey_estimate import (
    MeasuringTimes,
    needed_bytes,
    point_durations_s,
)
from gpr20_main_control.mid.survey_parameters import (
    SurveyParameters,
    check,
)
from gpr20_main_control.mid.survey_plan import survey_points
from gpr20_main_control.mid.survey_report import SurveyReport
from gpr20_main_control.mid.survey_run import SurveyPlan, SurveyRun
from gpr20_main_control.mid.survey_settings import SurveySettings
from gpr20_main_control.mid.survey_state import SurveyState


@dataclass(frozen=True)
class SurveyEstimate:
    """What a survey will be before it starts."""

    total_points: int
    duration_s: float


class MainControl:
    """Checks requests against the state and runs one survey at a time."""

    def __init__(
        self,
        robot: Robot,
        facts: RobotFacts,
        settings: SurveySettings,
        board: StatusBoard,
        clock: Clock,
        utc_now_ns: Callable[[], int],
        on_coverage: Callable[[Coverage], None],
    ) -> None:
        self._robot = robot
        self._facts = facts
        self._settings = settings
        self._board = board
        self._clock = clock
        self._utc_now_ns = utc_now_ns
        self._on_coverage = on_coverage
        self._requests = threading.Lock()
        self._parameters: Optional[SurveyParameters] = None
        self._stop = threading.Event()
        self._run: Optional[SurveyRun] = None
        self._thread: Optional[threading.Thread] = None
        self._positioner = Positioner(robot.axes(), facts.axes, self._stop, clock)

    def set_parameters(self, parameters: SurveyParameters) -> SurveyEstimate:
        """Check the parameters and keep them for the next survey; nothing moves.

        Raises:
            RequestRefusedError: A survey is running.
            SurveyParametersError: Parameters are not allowed; each is named.
        """
        with self._requests:
            self._refuse_while_running("the parameters cannot be changed")
            check(parameters, self._facts.travel)
            plan = self._plan(parameters, "")
            self._parameters = parameters
            self._board.enter(SurveyState.CONFIGURED, f"ready for {len(plan.points)} traces")
            return SurveyEstimate(len(plan.points), sum(plan.durations_s))

    def start(self) -> str:
        """Start a survey with the parameters set before and return its id.

        Raises:
            RequestRefusedError: A survey is running, or no parameters have been set.
        """
        with self._requests:
            self._refuse_while_running("another survey cannot start")
            if self._parameters is None:
                raise RequestRefusedError("no parameters have been set; set them, then start")
            plan = self._plan(self._parameters, str(uuid.uuid4()))
            self._begin(plan, self._parameters, None)
            return plan.survey_id

    def pause(self) -> str:
        """Hold the survey after the sample that is being measured.

        Raises:
            RequestRefusedError: No survey is measuring now.
        """
        with self._requests:
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
        with self._requests:
            status = self._board.status
            if status.state is SurveyState.PAUSED and self._run is not None:
                folder_end = f"_{status.survey_id[:8]}"
                if survey not in ("", status.survey_id) and not survey.endswith(folder_end):
                    raise RequestRefusedError(
                        f"the paused survey is {status.survey_id}, not {survey[:64]!r}; stop it "
                        "first"
                    )
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

    def _refuse_while_running(self, consequence: str) -> None:
        state = self._board.status.state
        if state.running:
            raise RequestRefusedError(
                f"a survey is {state.name}: {consequence}; stop it or wait for its end"
            )
        # The state is final a moment before the thread has ended.
        if self._thread is not None:
            self._thread.join()

    def _resume_from_disk(self, survey: str) -> str:
        reopened = self._robot.storage.reopen(survey)
        try:
            parameters = resumable_parameters(reopened, self._facts)
            check(parameters, self._facts.travel)
            plan = replace(
                self._plan(parameters, reopened.survey_id),
                stored=frozenset(reopened.stored_indices),
                last=reopened.last,
            )
            self._parameters = parameters
            self._begin(plan, parameters, reopened)
        except Gpr20Error as error:
            # Refused, so it must not stay open.
            self._robot.storage.close(reopened.survey_id, "failed", f"not resumed: {error}")
            raise
        return f"resuming with {len(plan.pending)} of {len(plan.points)} traces to go"

    def _begin(
        self, plan: SurveyPlan, parameters: SurveyParameters, reopened: Optional[ReopenedSurvey]
    ) -> None:
        former_json = "" if reopened is None else reopened.report_json
        coverage = Coverage(len(plan.points), plan.stored)
        report = SurveyReport(coverage, former_json, self._on_coverage)
        self._stop.clear()
        self._board.begin_survey(
            plan.survey_id, len(plan.points), len(plan.stored), sum(plan.pending_durations_s)
        )
        self._board.enter(SurveyState.CHECKING, "checking the robot")
        self._run = self._new_run(plan, parameters, reopened, report)
        self._thread = threading.Thread(target=self._run.run, name="survey")
        self._thread.start()

    def _plan(self, parameters: SurveyParameters, survey_id: str) -> SurveyPlan:
        points = survey_points(parameters, self._facts.travel)
        times = MeasuringTimes(
            self._settings.settle_s, self._settings.height_s, parameters.frequency_points
        )
        durations_s = point_durations_s(points, self._positioner.move_duration_s, times)
        scaled_s = [duration_s / self._facts.time_scale for duration_s in durations_s]
        return SurveyPlan(survey_id, points, scaled_s)

    def _new_run(
        self,
        plan: SurveyPlan,
        parameters: SurveyParameters,
        reopened: Optional[ReopenedSurvey],
        report: SurveyReport,
    ) -> SurveyRun:
        def make_record(instrument: InstrumentState) -> SurveyRecord:
            return self._record(plan, parameters, instrument)

        # Vibrations of a robot that runs N times faster die down N times faster.
        settle_s = self._settings.settle_s / self._facts.time_scale
        preparation = Preparation(
            parameters, self._settings, self._robot, self._positioner, make_record, reopened
        )
        measurement = PointMeasurement(
            self._robot,
            self._positioner,
            preparation,
            replace(self._settings, settle_s=settle_s),
            self._stop,
            self._clock,
        )
        return SurveyRun(
            plan,
            self._robot,
            self._positioner,
            preparation,
            measurement,
            report,
            self._board,
            self._stop,
            self._clock,
            self._utc_now_ns,
        )

    def _record(
        self, plan: SurveyPlan, parameters: SurveyParameters, instrument: InstrumentState
    ) -> SurveyRecord:
        metadata = {
            "simulated": self._facts.simulated,
            "parameters": asdict(parameters),
            "planned_traces": len(plan.points),
            "estimated_duration_s": sum(plan.durations_s),
            "instrument": {
                "identity": instrument.identity,
                "address": parameters.vna_address,
                "calibration_status": instrument.calibration,
                "calibration": CALIBRATION_MEANINGS.get(instrument.calibration, "unknown"),
                "sweep": asdict(instrument.setting),
            },
            "axes": {axis_id.value: asdict(one) for axis_id, one in self._facts.axes.items()},
            "settings": asdict(self._settings),
        }
        size = needed_bytes(len(plan.points), parameters.frequency_points, sum(plan.durations_s))
        return SurveyRecord(plan.survey_id, self._utc_now_ns(), json.dumps(metadata), size)
