"""The parts of the robot over ROS: axes, analyzer, height sensor and storage."""

from __future__ import annotations

import json
import math
import threading
from functools import partial
from typing import Any, Callable, List, Optional, Tuple

import actionlib
import numpy as np
import rospy

from gpr20_common.faults import PART_LOST, PART_SILENT
from gpr20_common.high.answers import fault_of, message_from, record_of
from gpr20_common.high.raw_message import microseconds, preserialized, ros_time, serialized
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import DeviceError, NodeLostError, UnconfirmedError
from gpr20_main_control.high.survey_topics import (
    SurveyTopics,
    coverage_message,
    only_from,
    progress_message,
)
from gpr20_main_control.mid.devices.robot import (
    ANALYZER_LIMIT_S,
    HEIGHT_LIMIT_S,
    SETUP_LIMIT_S,
    STORAGE_LIMIT_S,
    AnalyzerCalibration,
    AnalyzerSetup,
    AxisReading,
    Lease,
    SurveyEnd,
    SurveyRecord,
    SweepConfirmation,
    UnconfirmedSweep,
    motion_error,
)
from gpr20_msgs import srv
from gpr20_msgs.msg import (
    AxisAction,
    AxisGoal,
    AxisResult,
    CurrentCoordinate,
    SurveyCoverage,
    SurveyData,
)
from gpr20_survey.axes import AxisId, ZeroEpoch
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, PLAIN_NAMES, STORAGE_NAME
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep import AnalyzerSettings, CalibrationStatus, Sweep, SweepSettings
from gpr20_survey.trace.trace import Trace

# Reopening and closing read every file of a survey; opening a survey closes another one that is
# still open [s].
WHOLE_SURVEY_LIMIT_S = 620.0
# Services that are called for each trace; none of them moves anything.
# Nor does a lease: what a hung driver does late with one is refused or harmless.
AT_EVERY_POINT = ("get_data", "confirm_data", "get_height", "store_data", "lease")
# The driver ends a request within the limit that it stated; its answer needs some time too [s].
MARGIN_S = 5.0
# actionlib waits longer than it is asked to, but not as long as 0, which is for ever.
SERVER_POLL_S = 0.001
STOP_LIMIT_S = 5.0
# Nothing moves, but its process of the pulses may have to be started.
SET_ZERO_LIMIT_S = 30.0
LEASE_CALL_LIMIT_S = 1.5


class DeviceService:
    """A service of a device, which operators call by its plain name.

    Attributes:
        time_limit_s: Time limit of a call [s].
    """

    def __init__(
        self,
        device: Message,
        name: str,
        service_class: Any,
        time_limit_s: float,
        failure: Callable[[Message, Any], DeviceError] = lambda reason, _: DeviceError(reason),
        silence: Callable[[Message], DeviceError] = partial(DeviceError, fault=PART_SILENT),
    ) -> None:
        """Connect to nothing yet; `failure` and `silence` make the error of a call without success.

        `failure` is that of an answer which reports one, `silence` that of no answer.
        """
        self._device, self._failure, self._silence = device, failure, silence
        keep_open = name.rpartition("/")[2] in AT_EVERY_POINT
        self._client = ServiceClient(name, service_class, keep_open)
        self.time_limit_s, self.give_up = time_limit_s, self._client.give_up

    def __call__(self, *request: Any, **fields: Any) -> Any:
        """Call the service, with a request or its fields, and return the response of a success."""
        try:
            response = self._client.call(self.time_limit_s, *request, **fields)
        except ServiceUnavailableError as error:
            device = self._device
            silent = Message(
                "{device} did not answer; check that it runs", device=device, details=error
            )
            raise self._silence(silent) from error
        if not response.success:
            # What the part itself reports decides, also a note.
            reason = message_from(response)
            carried = Message("{reason}", reason=reason, details=self._client.name)
            raise self._failure(carried.with_fault(reason.cause), response)
        return response


class RosAxis:
    """Implements `gpr20_main_control.mid.devices.robot.Axis`."""

    def __init__(self, axis_id: AxisId, clock: Clock) -> None:
        """Connect to the axis in its namespace, such as x_axis.

        `clock` measures the age of a reading; the time of day may be set meanwhile.
        """
        group = self._group = f"{axis_id.value}_axis"
        driver = f"{group}/axis_driver"
        self._clock = clock
        # The last reading, and when it was received [s].
        self._last: Optional[Tuple[CurrentCoordinate, float]] = None
        self.received = threading.Event()
        # Not a SimpleActionClient: it drops what it receives about a goal before send_goal()
        # has returned, so the result of a very short move could be lost.
        self._client = _DriversClient(f"{group}/axis", driver)
        self._goal: Optional[actionlib.ClientGoalHandle] = None
        # Why the present move failed, None if it did not; empty while it lasts.
        self._ends: List[Optional[DeviceError]] = []
        name = PLAIN_NAMES[driver]
        failed = lambda reason, _answer: motion_error(reason)  # noqa: E731
        service = partial(DeviceService, name, failure=failed, silence=NodeLostError)
        # A homing may have begun, and continue.
        lost = partial(NodeLostError, fault=PART_LOST)
        self._homing = service(f"{group}/homing", srv.Command, 0.0, silence=lost)
        self._set_zero = service(f"{group}/set_zero", srv.Command, SET_ZERO_LIMIT_S)
        self._stop = service(f"{group}/stop", srv.Command, STOP_LIMIT_S)

        def taken(reason: Message, _answer: Any) -> DeviceError:
            return DeviceError(
                Message("{device} is not free: {reason}", device=name, reason=reason)
            )

        self._lease = service(f"{group}/lease", srv.AxisLease, LEASE_CALL_LIMIT_S, failure=taken)
        self._stops: List[threading.Thread] = []
        self._lock = threading.Lock()
        self._subscriber = rospy.Subscriber(
            f"{group}/current_coord",
            CurrentCoordinate,
            only_from(driver, self._note),
            queue_size=10,
        )

    def reading(self) -> Optional[AxisReading]:
        if self._last is None:
            return None
        last, received_s = self._last
        # Age by this machine's clock: the two machines' clocks may differ.
        age_s = self._clock.now_s() - received_s
        zero = ZeroEpoch(last.zero_epoch, microseconds(last.zero_time))
        return AxisReading(last.coordinate, last.homed, last.moving, age_s, zero)

    def lease(self, number: int = 0, release: bool = False) -> Lease:
        answer = self._lease(lease=number, release=release)
        return Lease(answer.lease, answer.limit_s)

    def is_connected(self) -> bool:
        return bool(self._client.wait_for_server(rospy.Duration(SERVER_POLL_S)))

    def begin_move(self, target: float) -> None:
        self._await_stops()
        ends = self._ends = []

        def note(goal: actionlib.ClientGoalHandle) -> None:
            if goal.get_comm_state() == actionlib.CommState.DONE:
                ends.append(move_failure(goal))
                self.received.set()

        # Stored, because a goal whose handle is deleted is no longer followed.
        self._goal = self._client.send_goal(AxisGoal(target_coordinate=target), note)

    def move_ended(self) -> bool:
        for failure in self._ends:
            if failure is not None:
                raise failure
        return bool(self._ends)

    def home(self, time_limit_s: float) -> None:
        self._await_stops()
        self._homing.time_limit_s = time_limit_s
        self._homing()

    def set_zero(self) -> None:
        self._set_zero()

    def stop(self) -> None:
        # A homing that waits for a lost node must not begin when the node is back.
        self._homing.give_up()
        goal = self._goal
        if goal is not None and goal.get_comm_state() != actionlib.CommState.DONE:
            # On an open connection: it arrives before the call, which has to connect first.
            goal.cancel()
        thread = threading.Thread(target=self._stop_now, name=f"stop {self._group}", daemon=True)
        with self._lock:
            thread.start()
            self._stops = [*filter(threading.Thread.is_alive, self._stops), thread]

    def _await_stops(self) -> None:
        """Return when no stop is pending: a late one would end the motion that begins now."""
        with self._lock:
            stops = self._stops
        for one in stops:
            one.join(2.0 * STOP_LIMIT_S)

    def _stop_now(self) -> None:
        try:
            self._stop()
        except DeviceError as error:
            # The motion of a driver that died, or is unreachable, ends by itself; if it is only
            # slow, this must be visible. When the robot is shut down, its axes stop by
            # themselves, and their nodes may have ended already.
            log = rospy.loginfo if rospy.core.is_shutdown_requested() else rospy.logerr
            log("%s could not be stopped: %s", self._group, error)

    def _note(self, message: CurrentCoordinate) -> None:
        self._last = message, self._clock.now_s()
        self.received.set()


class _DriversClient(actionlib.ActionClient):
    """An action client that listens to the driver of the axis alone."""

    def __init__(self, name: str, driver: str) -> None:
        # The base class subscribes with these.
        for callback in ("_status_cb", "_result_cb"):
            setattr(self, callback, only_from(driver, getattr(self, callback)))
        super().__init__(name, AxisAction)


def move_failure(goal: actionlib.ClientGoalHandle) -> Optional[DeviceError]:
    """Return why the move of a goal failed; None if it did not."""
    result: Optional[AxisResult] = goal.get_result()
    text = goal.get_goal_status_text()
    if result is None:
        return DeviceError(Message("the move ended without a result", details=text), PART_LOST)
    if result.success:
        return None
    # The result of a goal that actionlib itself refused has no message.
    return motion_error(message_from(result) if result.message else verbatim(text))


class RosAnalyzer:
    """Implements `gpr20_main_control.mid.devices.robot.Analyzer`."""

    def __init__(self) -> None:
        service = partial(DeviceService, PLAIN_NAMES[ANALYZER], time_limit_s=ANALYZER_LIMIT_S)
        self._connection = service("connection", srv.Connection)
        self._setup = service("freq_sweep_setup", srv.FreqSweepSetup, time_limit_s=SETUP_LIMIT_S)
        self._calibration = service("get_calibration_status", srv.GetCalibrationStatus)
        self._data = service("get_data", srv.GetData)
        self._confirmation = service(
            "confirm_data",
            srv.ConfirmData,
            failure=lambda reason, answer: UnconfirmedError(reason, answer.repeat),
        )

    def connect(self, address: str) -> str:
        return str(self._connection(connect=True, address=address).identity)

    def release(self) -> None:
        self._connection(connect=False)

    def calibration(self) -> AnalyzerCalibration:
        answer = self._calibration()
        if not answer.accepted:
            raise DeviceError(message_from(answer))
        return AnalyzerCalibration(
            CalibrationStatus(answer.status), json.loads(answer.details_json or "{}")
        )

    def configure(self, settings: SweepSettings) -> AnalyzerSetup:
        answer = self._setup(
            start_frequency_hz=settings.start_frequency_hz,
            stop_frequency_hz=settings.stop_frequency_hz,
            points=settings.points,
            **vars(settings.analyzer),
        )
        limit_s = answer.request_limit_s + MARGIN_S
        self._data.time_limit_s = self._confirmation.time_limit_s = limit_s
        accepted = record_of(SweepSettings, answer, analyzer=record_of(AnalyzerSettings, answer))
        return AnalyzerSetup(accepted, answer.sweep_duration_s, limit_s)

    def sweep(self) -> UnconfirmedSweep:
        data = self._data(confirm_later=True)
        sweep = Sweep(
            frequency_hz=np.array(data.frequency_hz),
            s21_real=np.array(data.s21_real),
            s21_imag=np.array(data.s21_imag),
            sweep_started_us=microseconds(data.sweep_started),
            sweep_ended_us=microseconds(data.sweep_ended),
            quality=tuple(data.quality),
            analyzer=record_of(AnalyzerSettings, data),
        )
        return UnconfirmedSweep(data.number, sweep)

    def confirm(self, number: int) -> SweepConfirmation:
        answer = self._confirmation(number=number)
        known = math.isfinite(answer.temperature_c)
        return SweepConfirmation(tuple(answer.quality), answer.temperature_c if known else None)


def height_over_ros() -> Callable[[], float]:
    """Return what measures the height of the antennas above the ground [m]."""
    measure = DeviceService(PLAIN_NAMES[HEIGHT_SENSOR], "get_height", srv.GetHeight, HEIGHT_LIMIT_S)
    return lambda: float(measure().height_m)


class RosStorage:
    """Implements `gpr20_main_control.mid.devices.robot.Storage`."""

    def __init__(self, topics: SurveyTopics) -> None:
        """Prepare the calls; `topics` makes the messages with which recordings end."""
        self._topics = topics
        service = partial(DeviceService, STORAGE_NAME)
        self._open = service("open_survey", srv.OpenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._reopen = service("reopen_survey", srv.ReopenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._add_fact = service("add_fact", srv.AddFact, STORAGE_LIMIT_S)
        self._store = service("store_data", srv.StoreData, STORAGE_LIMIT_S)
        self._close = service("close_survey", srv.CloseSurvey, WHOLE_SURVEY_LIMIT_S)

    def open(self, record: SurveyRecord) -> str:
        response = self._open(
            survey_id=record.survey_id,
            started=ros_time(record.started_us),
            metadata_json=record.metadata_json,
            needed_bytes=record.needed_bytes,
            interrupt_open=True,
        )
        return str(response.path)

    def reopen(self, survey: str) -> ReopenedSurvey:
        response = self._reopen(survey=survey, interrupt_open=True)
        recent = [trace_message.decode(serialized(one)) for one in response.recent]
        return record_of(ReopenedSurvey, response, recent=tuple(recent))

    def add_fact(self, survey_id: str, kind: Kind, values_json: str) -> int:
        response = self._add_fact(survey=survey_id, kind=kind.value, values_json=values_json)
        return int(response.stored_traces)

    def store(self, trace: Trace) -> None:
        # The trace is the only field of the request, so their bytes are the same.
        self._store(preserialized(srv.StoreDataRequest, trace_message.encode(trace)))

    def close(self, survey_id: str, end: SurveyEnd) -> None:
        progress, coverage = SurveyData(), SurveyCoverage()
        if end.coverage is not None:
            progress = progress_message(end.status)
            coverage = coverage_message(end.coverage, survey_id)
        self._close(
            survey_id=survey_id,
            outcome=end.outcome,
            reason=str(end.reason),
            reason_fault=fault_of(end.reason),
            status=self._topics.status_message(end.status),
            progress=progress,
            coverage=coverage,
        )
