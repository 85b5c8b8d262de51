"""One sample after another: height, sweep and confirmation at the present position.

A sweep is confirmed while the axes move; its trace is stored once it is confirmed.
"""

from __future__ import annotations

import threading
import uuid
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Callable, Dict, Optional, Tuple, TypeVar

import numpy as np

from gpr20_common.faults import OVERLOADED
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_main_control.errors import MOVED_BY_OTHERS, DeviceError
from gpr20_main_control.mid.devices.robot import (
    ANALYZER_LIMIT_S,
    HEIGHT_LIMIT_S,
    SETUP_LIMIT_S,
    AnalyzerCalibration,
    AnalyzerSetup,
    Position,
    SweepConfirmation,
)
from gpr20_main_control.mid.waits import Check, Workers, result_of
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.faults import NO_GROUND, VNA_SETTINGS
from gpr20_survey.plan.robot_description import HEIGHT_SENSOR, PLAIN_NAMES
from gpr20_survey.plan.survey_parameters import HeightPolicy
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.trace.sweep import Sweep, SweepSettings, storable_remark
from gpr20_survey.trace.trace import VNA_TEMPERATURE, AuxValue, Trace

if TYPE_CHECKING:  # the survey has this sampling
    from gpr20_main_control.mid.survey.survey import Survey

Result = TypeVar("Result")
THE_ANALYZER = Message("the VNA")


@dataclass(frozen=True)
class AnalyzerState:
    """What is known about the analyzer before a survey."""

    identity: str
    calibration: AnalyzerCalibration
    setup: AnalyzerSetup


def _in_words(sweep: SweepSettings) -> Message:
    return Message(
        "{points} points from {start_mhz:.12g} to {stop_mhz:.12g} MHz",
        points=sweep.points,
        start_mhz=1.0e-6 * sweep.start_frequency_hz,
        stop_mhz=1.0e-6 * sweep.stop_frequency_hz,
    )


class Confirmation:
    """The confirmation of one trace: it is stored once, when it is confirmed, or never.

    The survey may give the trace up at any moment, to measure its point again.

    Attributes:
        point: Where it was measured.
        confirmed: The trace, once it is confirmed and accepted for storing.
    """

    def __init__(
        self,
        point: SurveyPoint,
        trace: Trace,
        confirm: Callable[[], SweepConfirmation],
        store: Callable[[Trace], None],
        workers: Workers,
    ) -> None:
        """Begin; `confirm` raises if it is not confirmed, `store` returns at once."""
        self.point = point
        self._trace, self._confirm, self._store = trace, confirm, store
        self._lock = threading.Lock()
        self._given_up = False
        self._stored: Optional[Trace] = None
        self.confirmed: Future[Trace] = workers.begin(self._run)

    def _run(self) -> Trace:
        trace = self._completed(self._confirm())
        with self._lock:
            if self._given_up:
                raise DeviceError(Message("the confirmation came too late"), fault=OVERLOADED)
            self._stored = trace
            self._store(trace)
        return trace

    def give_up(self) -> Optional[Trace]:
        """Make sure that the trace is never stored, or return it if it is accepted already."""
        with self._lock:
            self._given_up = True
            return self._stored

    def _completed(self, confirmed: SweepConfirmation) -> Trace:
        aux, quality = self._trace.aux, (*self._trace.quality, *confirmed.remarks)
        if confirmed.temperature_c is not None:
            own = AuxValue(VNA_TEMPERATURE, confirmed.temperature_c, "degC", time_of_day_us())
            aux = (*aux, own)
        try:
            return replace(self._trace, quality=quality, aux=aux)
        except TraceRefusedError as error:
            raise DeviceError(error.message) from error


class Sampling:
    """Takes the samples of one survey; at most one sweep is unconfirmed.

    DeviceError says which part failed, or that the axes are elsewhere; an interruption ends each
    step, too.
    """

    def __init__(self, survey: Survey) -> None:
        self._survey, self._plan, self._robot = survey, survey.plan, survey.robot
        self._positioner, self._waits = survey.positioner, survey.waits
        self._interruption = survey.interruption
        # On a robot that runs N times faster, vibrations decay N times faster.
        self._settle_s = self._plan.settings.settle_s / self._plan.config.time_scale
        # Where the axes have settled: these fields of a trace, and its first remarks.
        self._place: Dict[str, Any] = {}
        self._remarks: Tuple[str, ...] = ()
        self._setup: Optional[AnalyzerSetup] = None
        self._wanted, last = survey.plan.sweep_settings, survey.plan.last
        # To the last bit those of every stored trace.
        self._frequencies_hz = self._wanted.frequencies_hz() if last is None else last.frequency_hz

    def check(self, next_index: int) -> AnalyzerState:
        """Check all that is needed to measure a point next; return the state of the analyzer.

        Nothing moves. A DeviceError says which check failed.
        """
        self._survey.positioner.check_alive()
        self._robot.description.check(self._plan.config)
        analyzer = self._check_analyzer(next_index)
        if self._plan.settings.on_height_failure is HeightPolicy.PAUSE:
            self._robot.workers.call(self._height, self._survey.interruption.check)
        self._robot.sensors.check_required()
        return analyzer

    def settle(self, point: SurveyPoint) -> None:
        """Return when vibrations have died down and the height is measured."""
        self._robot.description.check(self._plan.config)
        position = self._resting_at(point)
        height_call = self._robot.workers.begin(self._height)
        self._interruption.wait_s(self._settle_s)
        action = Message("height at point {index}", index=point.index)
        limit_s = self._plan.settings.attempts * HEIGHT_LIMIT_S
        with self._waits.shown(PLAIN_NAMES[HEIGHT_SENSOR], action, limit_s) as check:
            height_m, self._remarks = result_of(height_call, check)
        self._resting_at(point)
        self._place = {
            "x_coord_mm": position.x_mm,
            "y_coord_mm": position.y_mm,
            "z_coord_deg": position.z_deg,
            "zeros": position.zeros,
            "antennae_height_m": height_m,
        }

    def sweep(
        self, point: SurveyPoint, store: Callable[[Trace], None], remark: Optional[Message] = None
    ) -> Confirmation:
        """Take the sweep of a point at which the axes have settled, and begin to confirm it.

        `store` accepts the trace once it is confirmed, in another thread.
        """
        try:
            trace, number = self._swept(point, remark)
        except TraceRefusedError as error:
            # The operator can remove the cause, such as a wrong clock: the survey pauses.
            raise DeviceError(error.message) from error
        confirm = partial(self._robot.analyzer.confirm, number)
        return Confirmation(point, trace, confirm, store, self._robot.workers)

    def confirmed(self, sweep: Confirmation, check: Optional[Check] = None) -> Trace:
        """Return the trace of a sweep when it is confirmed and accepted for storing.

        An error of `check`, or else an interruption, ends the wait; the confirmation continues.
        """
        assert self._setup is not None
        limit_s = self._setup.request_limit_s
        action = Message("settings after the sweep at point {index}", index=sweep.point.index)
        with self._waits.shown(THE_ANALYZER, action, limit_s, check=check) as check_and_show:
            return result_of(sweep.confirmed, check_and_show)

    def _height(self) -> Tuple[float, Tuple[str, ...]]:
        """Return the height [m], and remarks on it; NaN if the survey may do without."""
        failure: Optional[DeviceError] = None
        for _attempt in range(self._plan.settings.attempts):
            try:
                return self._robot.height_m(), ()
            except DeviceError as error:
                failure = error
        assert failure is not None
        if self._plan.settings.on_height_failure is HeightPolicy.STORE_WITHOUT:
            return float("nan"), (storable_remark(f"no height: {failure}"),)
        raise DeviceError(
            Message("the antenna height could not be measured: {reason}", reason=failure.message),
            fault=NO_GROUND,
        ) from failure

    def _check_settings(self, found: SweepSettings, is_whole: bool) -> None:
        """Refuse a sweep of other frequencies, or with other settings, than those of the survey."""
        wanted = self._wanted
        if is_whole and found.analyzer.fulfils(wanted.analyzer):
            return
        shown = [one.analyzer.message if is_whole else _in_words(one) for one in (found, wanted)]
        raise DeviceError(
            Message(
                "the VNA has {found} instead of {wanted}; do not change its settings during a "
                "survey; if it is so again, correct the plan",
                found=shown[0],
                wanted=shown[1],
            ),
            fault=VNA_SETTINGS,
        )

    def _check_analyzer(self, next_index: int) -> AnalyzerState:
        analyzer, wanted = self._robot.analyzer, self._wanted
        address = self._plan.parameters.vna_address
        identity = self._call(lambda: analyzer.connect(address), Message("connection"))
        self._robot.description.check_identity(identity, self._plan.config)
        self._survey.analyzers.check(identity, next_index, self._survey.clock.time_of_day_us())
        setup = self._call(
            lambda: analyzer.configure(wanted), Message("setup of the sweep"), SETUP_LIMIT_S
        )
        accepted = setup.settings
        is_whole = replace(accepted, analyzer=wanted.analyzer) == wanted
        self._check_settings(accepted, is_whole)
        # Other settings, such as the output power, can have changed it.
        calibration = self._call(analyzer.calibration, Message("calibration status"))
        # What was left to the instrument stays as it is now: to the end of the survey.
        self._wanted, self._setup = accepted, setup
        return AnalyzerState(identity, calibration, setup)

    def _call(
        self, call: Callable[[], Result], action: Message, limit_s: float = ANALYZER_LIMIT_S
    ) -> Result:
        with self._survey.waits.shown(THE_ANALYZER, action, limit_s) as check:
            return self._robot.analyzer_calls.call(call, check)

    def _swept(self, point: SurveyPoint, remark: Optional[Message]) -> Tuple[Trace, int]:
        setup = self._setup
        assert setup is not None and self._place
        sweep_call = self._robot.workers.begin(self._robot.analyzer.sweep)
        action = Message("sweep at point {index}", index=point.index)
        limit_s, expected_s = setup.request_limit_s, setup.sweep_duration_s
        with self._waits.shown(THE_ANALYZER, action, limit_s, expected_s) as check:
            measured = result_of(sweep_call, check)
        self._interruption.check()
        self._resting_at(point)
        return self._trace(point, measured.sweep, remark), measured.number

    def _resting_at(self, point: SurveyPoint) -> Position:
        """Return the position if the axes rest at a point, with the zeros of the survey."""
        position = self._positioner.position()
        self._survey.zeros.check(position.zeros)
        planned = Position(point.x_mm, point.y_mm, point.z_deg, position.zeros)
        if position != planned:
            raise DeviceError(
                Message(
                    "the axes are at {position} instead of {planned} at point {index}; nothing "
                    "else may move them during a survey",
                    position=position.message,
                    planned=planned.message,
                    index=point.index,
                ),
                fault=MOVED_BY_OTHERS,
            )
        return position

    def _trace(self, point: SurveyPoint, sweep: Sweep, remark: Optional[Message]) -> Trace:
        hz = sweep.frequency_hz
        found = SweepSettings(float(hz[0]), float(hz[-1]), len(hz), sweep.analyzer)
        self._check_settings(found, np.array_equal(hz, self._frequencies_hz))
        aux, sensor_remarks = self._robot.sensors.for_trace()
        timestamp_us = time_of_day_us()
        self._survey.clock_steps.check()
        own = () if remark is None else (storable_remark(str(remark)),)
        on_place = (*self._remarks, *self._survey.zeros.remark)
        quality = (*sweep.quality, *on_place, *own, *sensor_remarks)
        measured = {**vars(sweep), "quality": quality}
        return Trace(
            **measured,
            **self._place,
            survey_id=self._plan.survey_id,
            sample_id=str(uuid.uuid4()),
            index=point.index,
            timestamp_us=timestamp_us,
            aux=aux,
        )
