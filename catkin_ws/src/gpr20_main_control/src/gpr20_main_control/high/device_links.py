"""The analyzer, the height sensor and the storage, over ROS services."""

from __future__ import annotations

from typing import Any, Tuple

import genpy
import rospy

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.robot import (
    OpenedSurvey,
    ReopenedSurvey,
    Sample,
    StoredTrace,
    SurveyRecord,
    Sweep,
    SweepSetting,
)
from gpr20_msgs.msg import Trace
from gpr20_msgs.srv import (
    CloseSurvey,
    Connection,
    FreqSweepSetup,
    GetCalibrationStatus,
    GetData,
    GetFreq,
    GetHeight,
    OpenSurvey,
    ReopenSurvey,
    ReportSurvey,
    StoreData,
)

TRACE_FORMAT = "gpr20-trace/1"
# Opening again and closing read every file of a survey, and so does opening a survey when
# another is to be closed [s].
WHOLE_SURVEY_LIMIT_S = 620.0


class Caller:
    """A service whose failures are the device's failures."""

    def __init__(self, name: str, service_class: Any, time_limit_s: float) -> None:
        self._client = ServiceClient(name, service_class)
        self._time_limit_s = time_limit_s

    def __call__(self, **fields: Any) -> Any:
        """Call the service and return the response of a success.

        Raises:
            DeviceError: No answer came, or the answer was a failure.
        """
        try:
            response = self._client.call(self._time_limit_s, **fields)
        except ServiceUnavailableError as error:
            raise DeviceError(str(error)) from error
        if not response.success:
            raise DeviceError(f"{self._client.name}: {response.message}")
        return response


class AnalyzerLink:
    """Implements `gpr20_main_control.mid.robot.Analyzer`."""

    def __init__(self, time_limit_s: float) -> None:
        self._connection = Caller("connection", Connection, time_limit_s)
        self._setup = Caller("freq_sweep_setup", FreqSweepSetup, time_limit_s)
        self._frequencies = Caller("get_freq", GetFreq, time_limit_s)
        self._calibration = Caller("get_calibration_status", GetCalibrationStatus, time_limit_s)
        self._data = Caller("get_data", GetData, time_limit_s)

    def connect(self, address: str) -> str:
        """Connect, or connect again, and return the instrument's identity."""
        return str(self._connection(connect=True, address=address).identity)

    def calibration(self) -> int:
        """Return the calibration status on the instrument's own scale."""
        return int(self._calibration().status)

    def configure(self, setting: SweepSetting) -> SweepSetting:
        """Configure the sweep and return what the instrument accepted."""
        accepted = self._setup(
            start_frequency_hz=setting.start_frequency_hz,
            stop_frequency_hz=setting.stop_frequency_hz,
            points=setting.points,
        )
        return SweepSetting(
            accepted.start_frequency_hz, accepted.stop_frequency_hz, accepted.points
        )

    def frequencies_hz(self) -> Tuple[float, ...]:
        """Return the frequencies of the sweep [Hz]."""
        return tuple(self._frequencies().frequency_hz)

    def sweep(self) -> Sweep:
        """Take one sweep that starts now."""
        data = self._data()
        return Sweep(
            s21_real=tuple(data.s21_real),
            s21_imag=tuple(data.s21_imag),
            started_ns=data.sweep_started.to_nsec(),
            ended_ns=data.sweep_ended.to_nsec(),
            quality=tuple(data.quality),
            setting=SweepSetting(data.start_frequency_hz, data.stop_frequency_hz, data.points),
            calibration=data.calibration_status,
        )


class HeightLink:
    """Implements `gpr20_main_control.mid.robot.HeightSensor`."""

    def __init__(self, time_limit_s: float) -> None:
        self._measure = Caller("get_height", GetHeight, time_limit_s)

    def height_m(self) -> float:
        """Measure the height of the antennas above the ground [m] now."""
        return float(self._measure().height_m)


class StorageLink:
    """Implements `gpr20_main_control.mid.robot.Storage`."""

    def __init__(self, time_limit_s: float) -> None:
        self._open = Caller("open_survey", OpenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._reopen = Caller("reopen_survey", ReopenSurvey, WHOLE_SURVEY_LIMIT_S)
        self._report = Caller("report_survey", ReportSurvey, time_limit_s)
        self._store = Caller("store_data", StoreData, time_limit_s)
        self._close = Caller("close_survey", CloseSurvey, WHOLE_SURVEY_LIMIT_S)

    def open(self, record: SurveyRecord) -> OpenedSurvey:
        """Begin a survey; one that is still open is closed as interrupted."""
        response = self._open(
            survey_id=record.survey_id,
            started=_time(record.started_ns),
            metadata_json=record.metadata_json,
            needed_bytes=record.needed_bytes,
            interrupt_open=True,
        )
        return OpenedSurvey(str(response.path), str(response.interrupted))

    def reopen(self, survey: str) -> ReopenedSurvey:
        """Open a survey again, by its id or folder; another that is open is interrupted."""
        response = self._reopen(survey=survey, interrupt_open=True)
        last = response.last
        stored_last = StoredTrace(
            last.index,
            last.antennae_height_m,
            tuple(last.frequency_hz),
            tuple(last.s21_real),
            tuple(last.s21_imag),
        )
        return ReopenedSurvey(
            survey_id=response.survey_id,
            folder=response.path,
            metadata_json=response.metadata_json,
            report_json=response.report_json,
            stored_indices=tuple(response.stored_indices),
            last=stored_last if last.frequency_hz else None,
            interrupted=response.interrupted,
        )

    def report(self, survey_id: str, report_json: str) -> None:
        """Keep a report of the survey beside its metadata."""
        self._report(survey_id=survey_id, report_json=report_json)

    def store(self, sample: Sample) -> None:
        """Store a trace; returning means that it is durable."""
        self._store(trace=trace_message(sample))

    def close(self, survey_id: str, outcome: str, reason: str) -> int:
        """End a survey and return how many traces its folder holds."""
        response = self._close(survey_id=survey_id, outcome=outcome, reason=reason)
        return int(response.stored_traces)


def trace_message(sample: Sample) -> Trace:
    """Return the message of a sample; the names are the same."""
    return Trace(
        format=TRACE_FORMAT,
        survey_id=sample.survey_id,
        sample_id=sample.sample_id,
        index=sample.index,
        timestamp=_time(sample.timestamp_ns),
        x_coord_mm=sample.x_coord_mm,
        y_coord_mm=sample.y_coord_mm,
        z_coord_deg=sample.z_coord_deg,
        antennae_height_m=sample.antennae_height_m,
        frequency_hz=sample.frequency_hz,
        s21_real=sample.sweep.s21_real,
        s21_imag=sample.sweep.s21_imag,
        sweep_started=_time(sample.sweep.started_ns),
        sweep_ended=_time(sample.sweep.ended_ns),
        quality=list(sample.quality),
    )


def utc_now_ns() -> int:
    """Return the time of day [ns UTC] in whole microseconds, the resolution on disk."""
    return int(rospy.Time.now().to_nsec()) // 1000 * 1000


def _time(time_ns: int) -> genpy.Time:
    return genpy.Time(*divmod(time_ns, 1_000_000_000))
