"""The control's answers to requests: parameters, start, stop, resume."""

from __future__ import annotations

import json
import threading
import uuid
from dataclasses import asdict, dataclass, replace
from typing import Callable, Dict, Optional

from gpr20_axis_driver.mid.axis_parameters import AxisParameters
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import (
    CALIBRATION_MEANINGS,
    InstrumentState,
    Preparation,
)
from gpr20_main_control.mid.robot import AxisId, Robot, SurveyRecord
from gpr20_main_control.mid.status_board import StatusBoard
from gpr20_main_control.mid.survey_estimate import (
    MeasuringTimes,
    needed_bytes,
    point_durations_s,
)
from gpr20_main_control.mid.survey_parameters import (
    RobotTravel,
    SurveyParameters,
    Travel,
    check,
)
from gpr20_main_control.mid.survey_plan import survey_points
from gpr20_main_control.mid.survey_run import SurveyPlan, SurveyRun
from gpr20_main_control.mid.survey_settings import SurveySettings
from gpr20_main_control.mid.survey_state import SurveyState


@dataclass(frozen=True)
class RobotFacts:
    """What is fixed for one robot.

    Attributes:
        axes: Parameters of its axes.
        simulated: Whether it is simulated.
        time_scale: How many times faster than the real robot it runs; 1 if it is real.
    """

    axes: Dict[AxisId, AxisParameters]
    simulated: bool
    time_scale: float = 1.0

    @property
    def travel(self) -> RobotTravel:
        """What the axes can do."""
        x, y, z = (self.axes[axis_id] for axis_id in AxisId)
        return RobotTravel(_travel(x), _travel(y), _travel(z))


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
    ) -> None:
        self._robot = robot
        self._facts = facts
        self._settings = settings
        self._board = board
        self._clock = clock
        self._utc_now_ns = utc_now_ns
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
            plan = self._plan(parameters)
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
            plan = self._plan(self._parameters)
            self._stop.clear()
            self._board.begin_survey(plan.survey_id, len(plan.points), sum(plan.durations_s))
            self._board.enter(SurveyState.CHECKING, "checking the robot")
            self._run = self._new_run(plan, self._parameters)
            self._thread = threading.Thread(target=self._run.run, name="survey")
            self._thread.start()
            return plan.survey_id

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

    def resume(self, survey_id: str) -> str:
        """Go on with the paused survey.

        Raises:
            RequestRefusedError: No survey, or another one, is paused.
        """
        with self._requests:
            status = self._board.status
            if status.state is not SurveyState.PAUSED or self._run is None:
                raise RequestRefusedError(
                    f"no survey is paused (the control is {status.state.name}); there is nothing "
                    "to resume"
                )
            if survey_id not in ("", status.survey_id):
                raise RequestRefusedError(
                    f"the paused survey is {status.survey_id}, not {survey_id[:64]!r}"
                )
            self._run.resume()
            return "resuming"

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

    def _plan(self, parameters: SurveyParameters) -> SurveyPlan:
        points = survey_points(parameters, self._facts.travel)
        times = MeasuringTimes(
            self._settings.settle_s, self._settings.height_s, parameters.frequency_points
        )
        durations_s = point_durations_s(points, self._positioner.move_duration_s, times)
        scaled_s = [duration_s / self._facts.time_scale for duration_s in durations_s]
        return SurveyPlan(str(uuid.uuid4()), points, scaled_s)

    def _new_run(self, plan: SurveyPlan, parameters: SurveyParameters) -> SurveyRun:
        def make_record(instrument: InstrumentState) -> SurveyRecord:
            return self._record(plan, parameters, instrument)

        # Vibrations of a robot that runs N times faster die down N times faster.
        settle_s = self._settings.settle_s / self._facts.time_scale
        preparation = Preparation(
            parameters, self._settings, self._robot, self._positioner, make_record
        )
        return SurveyRun(
            plan,
            self._robot,
            self._positioner,
            preparation,
            replace(self._settings, settle_s=settle_s),
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


def _travel(parameters: AxisParameters) -> Travel:
    return Travel(parameters.min_coord, parameters.max_coord, parameters.step_size)
