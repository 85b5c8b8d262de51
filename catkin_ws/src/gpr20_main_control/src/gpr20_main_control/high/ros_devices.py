"""The analyzer, the height sensor and the storage, over ROS services."""

from __future__ import annotations

import json
import math
from functools import partial
from typing import Any, Callable

import numpy as np

from gpr20_common.faults import PART_SILENT
from gpr20_common.high.answers import fault_of, message_from, record_of
from gpr20_common.high.raw_message import microseconds, preserialized, ros_time, serialized
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, UnconfirmedError
from gpr20_main_control.high.survey_topics import (
    SurveyTopics,
    coverage_message,
    progress_message,
)
from gpr20_main_control.mid.devices.robot import (
    SETUP_LIMIT_S,
    AnalyzerCalibration,
    AnalyzerSetup,
    SurveyEnd,
    SurveyRecord,
    SweepConfirmation,
    UnconfirmedSweep,
)
from gpr20_msgs import srv
from gpr20_msgs.msg import SurveyCoverage, SurveyData
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, PLAIN_NAMES, STORAGE_NAME
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_survey.trace.trace import Trace

# Reopening and closing read every file of a survey; opening a survey closes another one that is
# still open [s].
WHOLE_SURVEY_LIMIT_S = 620.0
# Services that are called for each trace; none of them moves anything.
AT_EVERY_POINT = frozenset(("get_data", "confirm_data", "get_height", "store_data"))
# The driver ends a request within the limit that it stated; its answer needs some time too [s].
MARGIN_S = 5.0
# A connection that is made ahead of a call and takes longer is left to the call [s].
PREPARATION_LIMIT_S = 1.0


def no_answer(device: Message, error: ServiceUnavailableError) -> Message:
    return Message("{device} did not answer; check that it runs", device=device, details=error)


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
    ) -> None:
        """Connect to nothing yet; `failure` makes the error of an answer that is one."""
        self._device, self._failure = device, failure
        self._client = ServiceClient(name, service_class, keep_open=name in AT_EVERY_POINT)
        self.time_limit_s = time_limit_s

    def __call__(self, *request: Any, **fields: Any) -> Any:
        """Call the service, with a request or its fields, and return the response of a success.

        Raises:
            DeviceError: No answer came, or the answer was a failure.
        """
        try:
            response = self._client.call(self.time_limit_s, *request, **fields)
        except ServiceUnavailableError as error:
            raise DeviceError(no_answer(self._device, error), fault=PART_SILENT) from error
        if not response.success:
            # What the part itself reports decides, also a note.
            reason = message_from(response)
            carried = Message("{reason}", reason=reason, details=self._client.name)
            raise self._failure(carried.with_fault(reason.cause), response)
        return response

    def prepare(self) -> None:
        """Connect, so that a call that follows soon need not; a failure shows at the call."""
        self._client.prepare(PREPARATION_LIMIT_S)


class RosAnalyzer:
    """Implements `gpr20_main_control.mid.devices.robot.Analyzer`."""

    def __init__(self, time_limit_s: float) -> None:
        service = partial(DeviceService, PLAIN_NAMES[ANALYZER], time_limit_s=time_limit_s)
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

    def prepare(self) -> None:
        self._data.prepare()

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


def height_over_ros(time_limit_s: float) -> Callable[[], float]:
    """Return what measures the height of the antennas above the ground [m]."""
    measure = DeviceService(PLAIN_NAMES[HEIGHT_SENSOR], "get_height", srv.GetHeight, time_limit_s)
    return lambda: float(measure().height_m)


class RosStorage:
    """Implements `gpr20_main_control.mid.devices.robot.Storage`."""

    def __init__(self, time_limit_s: float, topics: SurveyTopics) -> None:
        """Prepare the calls; `topics` makes the messages with which recordings end."""
        self._topics = topics
        service = partial(DeviceService, STORAGE_NAME)
        self._open = service("open_survey", srv.OpenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._reopen = service("reopen_survey", srv.ReopenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._add_fact = service("add_fact", srv.AddFact, time_limit_s)
        self._store = service("store_data", srv.StoreData, time_limit_s)
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
