"""One survey, from its checks to its end."""

from __future__ import annotations

import threading
import uuid
from dataclasses import dataclass
from typing import Callable, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError, StopRequested
from gpr20_main_control.mid.background import in_background, result_of
from gpr20_main_control.mid.positioner import Positioner
from gpr20_main_control.mid.preparation import Preparation
from gpr20_main_control.mid.robot import Robot, Sample, Sweep
from gpr20_main_control.mid.status_board import StatusBoard
from gpr20_main_control.mid.storage_queue import StorageQueue
from gpr20_main_control.mid.survey_estimate import RemainingTime
from gpr20_main_control.mid.survey_plan import SurveyPoint
from gpr20_main_control.mid.survey_settings import HeightPolicy, SurveySettings
from gpr20_main_control.mid.survey_state import SurveyState

# Traces that wait for the disk when a survey is stopped get this long to be stored [s].
STOPPING_LIMIT_S = 60.0
POLL_S = 0.05


@dataclass(frozen=True)
class SurveyPlan:
    """What a survey will do: its points in order, and how long each takes [s]."""

    survey_id: str
    points: Sequence[SurveyPoint]
    durations_s: Sequence[float]


class SurveyRun:
    """Carries out one plan. `run` is the body of the survey's thread."""

    def __init__(
        self,
        plan: SurveyPlan,
        robot: Robot,
        positioner: Positioner,
        preparation: Preparation,
        settings: SurveySettings,
        board: StatusBoard,
        stop: threading.Event,
        clock: Clock,
        utc_now_ns: Callable[[], int],
    ) -> None:
        self._plan = plan
        self._robot = robot
        self._positioner = positioner
        self._preparation = preparation
        self._settings = settings
        self._board = board
        self._stop = stop
        self._clock = clock
        self._utc_now_ns = utc_now_ns
        self._resume = threading.Event()
        self._queue = StorageQueue(robot.storage, clock, self._count_stored)
        self._remaining = RemainingTime(plan.durations_s)
        self._next = 0
        self._surveying_since_s: Optional[float] = None
        self._surveyed_s = 0.0

    def run(self) -> None:
        """Carry out the survey; every way out ends in a final state with a message."""
        try:
            self._survey()
            self._finish()
        except StopRequested:
            self._end(SurveyState.STOPPED, "stopped", "stopped on request")
        except Exception as error:
            self._end(SurveyState.FAILED, "failed", str(error))
            if not isinstance(error, DeviceError):
                raise
        finally:
            self._queue.close()

    def resume(self) -> None:
        """Go on after a pause."""
        self._resume.set()

    def _survey(self) -> None:
        while True:
            try:
                self._prepare()
                self._board.enter(SurveyState.SURVEYING, "measuring")
                self._surveying_since_s = self._clock.now_s()
                while self._next < len(self._plan.points):
                    self._visit(self._plan.points[self._next])
                self._queue.drain()
                return
            except DeviceError as error:
                # A part that was told to stop fails, too; that is no reason to pause.
                self._raise_if_stopped()
                if not self._preparation.survey_is_open:
                    raise
                self._pause(str(error))

    def _prepare(self) -> None:
        self._preparation.check()
        self._raise_if_stopped()
        self._preparation.open_survey()
        self._board.enter(SurveyState.HOMING, "homing the axes that are not homed")
        self._positioner.home()
        self._queue.retry()

    def _visit(self, point: SurveyPoint) -> None:
        self._raise_if_stopped()
        self._board.aim(point)
        self._positioner.move_to(point)
        if self._clock.wait_s(self._stop, self._settings.settle_s):
            self._raise_if_stopped()
        before = self._positioner.position()
        sweep, height_m, remarks = self._measure()
        if self._positioner.position() != before:
            raise DeviceError(
                f"the axes moved during the sweep at point {point.index}; nobody else may move "
                "them during a survey"
            )
        sample = Sample(
            survey_id=self._plan.survey_id,
            sample_id=str(uuid.uuid4()),
            index=point.index,
            timestamp_ns=self._utc_now_ns(),
            x_coord_mm=before.x_mm,
            y_coord_mm=before.y_mm,
            z_coord_deg=before.z_deg,
            antennae_height_m=height_m,
            frequency_hz=self._preparation.frequencies_hz,
            sweep=sweep,
            quality=sweep.quality + remarks,
        )
        # Counted before the wait for room: the queue has the sample even if that fails.
        self._next += 1
        self._queue.put(sample, self._stop)

    def _measure(self) -> Tuple[Sweep, float, Tuple[str, ...]]:
        height, sweep_call = in_background(self._height), in_background(self._sweep)
        sweep = result_of(sweep_call, self._stop)
        height_m, remarks = result_of(height, self._stop)
        self._raise_if_stopped()
        return sweep, height_m, remarks

    def _sweep(self) -> Sweep:
        for _attempt in range(self._settings.attempts - 1):
            try:
                return self._robot.analyzer.sweep()
            except DeviceError:
                self._raise_if_stopped()
                self._preparation.check_analyzer()
        return self._robot.analyzer.sweep()

    def _height(self) -> Tuple[float, Tuple[str, ...]]:
        failure: Optional[DeviceError] = None
        for _attempt in range(self._settings.attempts):
            try:
                return self._robot.height_sensor.height_m(), ()
            except DeviceError as error:
                failure = error
        assert failure is not None
        if self._settings.on_height_failure == HeightPolicy.STORE_WITHOUT.value:
            return float("nan"), (f"no height: {failure}"[:200],)
        raise DeviceError(f"the antenna height could not be measured: {failure}") from failure

    def _pause(self, reason: str) -> None:
        self._hold_time()
        self._resume.clear()
        self._board.enter(
            SurveyState.PAUSED, f"paused: {reason}; resume when it is mended, or stop"
        )
        while not self._resume.is_set():
            self._raise_if_stopped()
            self._clock.wait_s(self._resume, POLL_S)
        self._board.enter(SurveyState.CHECKING, "checking the robot before going on")

    def _finish(self) -> None:
        stored = self._robot.storage.close(self._plan.survey_id, "finished", "every point measured")
        total = len(self._plan.points)
        if stored != total:
            self._board.enter(
                SurveyState.FAILED, f"the survey's folder holds {stored} of {total} traces"
            )
            return
        self._board.enter(
            SurveyState.FINISHED, f"finished: {stored} traces in {self._preparation.folder}"
        )

    def _end(self, state: SurveyState, outcome: str, reason: str) -> None:
        """End before the plan is done; nothing here may keep the rest from happening."""
        self._hold_time()
        self._positioner.stop()
        if state is SurveyState.STOPPED:
            self._board.enter(SurveyState.STOPPING, "stopping: storing what has been measured")
        message = reason
        if self._preparation.survey_is_open:
            message += self._close_early(outcome, reason)
        self._board.enter(state, message)

    def _close_early(self, outcome: str, reason: str) -> str:
        try:
            self._queue.retry()
            self._queue.drain(STOPPING_LIMIT_S)
            stored = self._robot.storage.close(self._plan.survey_id, outcome, reason)
        except DeviceError as error:
            return f"; the recordings could not be finished: {error}"
        return f"; {stored} of {len(self._plan.points)} traces in {self._preparation.folder}"

    def _count_stored(self, stored: int) -> None:
        elapsed_s = self._surveyed_s
        if self._surveying_since_s is not None:
            elapsed_s += self._clock.now_s() - self._surveying_since_s
        self._board.progress(stored, self._remaining.remaining_s(stored, elapsed_s))

    def _hold_time(self) -> None:
        if self._surveying_since_s is not None:
            self._surveyed_s += self._clock.now_s() - self._surveying_since_s
            self._surveying_since_s = None

    def _raise_if_stopped(self) -> None:
        if self._stop.is_set():
            raise StopRequested("the survey was told to stop")
