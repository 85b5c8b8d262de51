"""One survey in the storage: its folder, its traces, its facts and its end."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import asdict
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Deque, Dict, Mapping, Optional, Sequence, Tuple

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, Severity
from gpr20_common.mid.codec import plain
from gpr20_main_control.faults import CONFIGURATION_CHANGED
from gpr20_main_control.mid.devices.instruments import AnalyzerState
from gpr20_main_control.mid.devices.robot import SurveyEnd, SurveyRecord
from gpr20_main_control.mid.survey.repeats import Repeated
from gpr20_main_control.mid.survey.storage_queue import ATTEMPTS, CAPACITY, RETRY_S, StorageQueue
from gpr20_main_control.mid.survey.survey_plan import (
    PLAN_ID,
    PLAN_SET_BY,
    RemainingTime,
    SurveyPlan,
)
from gpr20_main_control.mid.survey.survey_status import Status
from gpr20_main_control.mid.waits import Check, ExpectedWait
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.soil_note import PLANNED
from gpr20_survey.folder.survey_metadata import message_record
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.recorded_plan import REFINES
from gpr20_survey.plan.robot_description import STORAGE_NAME
from gpr20_survey.plan.sensors import SENSORS
from gpr20_survey.plan.survey_cost import needed_bytes
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.utc_time import iso_text

if TYPE_CHECKING:  # the survey has this archive
    from gpr20_main_control.mid.survey.survey import Survey


class SurveyArchive:
    """Stores a survey, and knows how much of it is stored durably.

    A `check` that a method takes is called repeatedly while the method waits for the storage; an
    error that it raises ends the wait.

    Attributes:
        queue: The traces that are not stored durably yet.
        folder: The survey's folder; empty before it is made.
    """

    def __init__(self, survey: Survey) -> None:
        """Begin with what is stored already."""
        plan, robot = survey.plan, survey.robot
        self._survey, self._plan = survey, plan
        self._storage, self._calls = robot.storage, robot.storage_calls
        self._sensors = robot.sensors.recorded()
        self.folder = "" if plan.reopened is None else plan.reopened.path
        self._facts: Deque[Tuple[Kind, Dict[str, Any]]] = deque()
        self._reported_analyzers = survey.analyzers.used
        self._sensors_noted = False
        self._closing_report = ""
        self._closing_count = 0
        self._record: Optional[Tuple[AnalyzerState, SurveyRecord]] = None
        self._remaining = RemainingTime(plan.pending_durations_s)
        self._measuring_since_s: Optional[float] = None
        self._measured_s = 0.0
        self.queue = StorageQueue(robot.storage, survey.clock, self._note_stored)

    def open(self, analyzer: AnalyzerState, check: Check) -> str:
        """Make the survey's folder and begin its recordings, or reopen them.

        The storage may have been restarted since; reopening an open survey changes nothing.

        Returns:
            Folder of another survey that was still open and was closed; empty if none.

        Raises:
            DeviceError: The disk has no room, or the folder cannot be made.
        """
        if self.folder:
            self.reopen(check)
            self.send_facts(check)
            self._note_other_sensors()
            if self._survey.analyzers.used != self._reported_analyzers:
                # Before the first trace of another analyzer.
                self._send_report(self._survey.report.to_json(), check)
                self._reported_analyzers = self._survey.analyzers.used
            return ""
        record = self._record_with(analyzer)
        opened = self._calls.call(lambda: self._storage.open(record), check)
        self.folder = opened.folder
        self._reported_analyzers = self._survey.analyzers.used
        self.send_facts(check)
        return opened.interrupted

    def reopen(self, check: Check) -> None:
        """Reopen the survey in the storage; if it is open, nothing changes."""
        name = PurePosixPath(self.folder).name
        self._calls.call(lambda: self._storage.reopen(name), check)

    def wait_for_room(self, point: SurveyPoint) -> None:
        """Return when few enough traces, up to that of a point, wait for the disk, or raise."""
        self._wait_until_left(CAPACITY, point)

    def drain(self) -> None:
        """Return when every trace is stored durably, or raise."""
        self._wait_until_left(0, self._plan.points[-1])

    def start_timing(self) -> None:
        """Begin to count time as measuring time."""
        self._measuring_since_s = self._survey.clock.now_s()

    def stop_timing(self) -> None:
        """Stop counting time as measuring time."""
        self._measured_s = self._elapsed_s()
        self._measuring_since_s = None

    def add_fact(self, kind: Kind, **values: Any) -> None:
        """Keep a fact with the present time, by which the storage knows a repeated one.

        It is stored with the next `send_facts`.
        """
        self._facts.append((kind, {"time": iso_text(time_of_day_us()), **values}))

    def add_message(self, kind: Kind, message: Message) -> None:
        """Keep a sentence: as text, and as template and values."""
        self.add_fact(kind, text=str(message), message=message_record(message))

    def send_facts(self, check: Check) -> None:
        """Store the facts that wait, in their order; after an error the rest waits."""
        while self._facts:
            kind, values = self._facts[0]
            self._send(kind, json.dumps(values, allow_nan=False), check)
            self._facts.popleft()

    def note_repeats(self, repeats: Sequence[Repeated], check: Check) -> None:
        """Store the results of repeated measurements, and the zeros that they prove."""
        for repeated in repeats:
            self._survey.report.note_repeat(repeated, time_of_day_us())
        self._send_report(self._survey.report.to_json(), check)

    def send_last_report(self, check: Check) -> int:
        """Store the report of the survey's end; return how many traces its folder holds."""
        report_json = self._survey.report.to_json()
        # Once: a survey that was closed by a call whose answer was lost accepts no report.
        if report_json != self._closing_report:
            self._closing_count = self._send_report(report_json, check)
            self._closing_report = report_json
        return self._closing_count

    def close(self, outcome: str, reason: Message, status: Status, check: Check) -> None:
        """Close the survey.

        Args:
            outcome: One word, for survey.json.
            reason: Why it ended; without a fault it has that which the status reports.
            status: The last one of the survey.
            check: Ends the wait.
        """
        survey_id = self._plan.survey_id
        cause = status.message.cause
        is_failure = cause is not None and cause.severity is not Severity.WARNING
        if status.state is not SurveyState.FINISHED and not reason.fault_code and is_failure:
            reason = reason.with_fault(cause)
        end = SurveyEnd(outcome, reason, status, self._survey.coverage)
        self._calls.call(lambda: self._storage.close(survey_id, end), check)

    def _wait_until_left(self, traces: int, point: SurveyPoint) -> None:
        limit_s = self._survey.robot.description.limits.storage_limit_s
        action = Message("traces up to point {index}", index=point.index)
        wait = ExpectedWait(STORAGE_NAME, action, 0.0, ATTEMPTS * (limit_s + RETRY_S))
        with self._survey.waits.shown(wait) as check:
            self.queue.wait_until_left(traces, check)

    def _record_with(self, analyzer: AnalyzerState) -> SurveyRecord:
        # The same record again if the answer to the first call was lost: the storage knows it.
        if self._record is None or self._record[0] != analyzer:
            recorded = {**self._survey.robot.description.recorded(), SENSORS: self._sensors}
            self._record = (analyzer, survey_record(self._plan, analyzer, recorded))
        return self._record[1]

    def _note_other_sensors(self) -> None:
        """Note once that a survey continues with other sensors than it began with."""
        former = self._plan.recorded_sensors
        if former in (None, self._sensors) or self._sensors_noted:
            return
        self._sensors_noted = True
        self._survey.note_warning(
            Message(
                "the survey continues with other sensors beside the radar: {present}; at its "
                "start: {former}; stop it if it needs those",
                present=_names(self._sensors),
                former=_names(former or []),
                details=json.dumps(self._sensors),
            ).with_fault(CONFIGURATION_CHANGED.as_warning())
        )

    def _send_report(self, report_json: str, check: Check) -> int:
        self.send_facts(check)
        return self._send(Kind.REPORT, report_json, check)

    def _send(self, kind: Kind, values_json: str, check: Check) -> int:
        survey_id = self._plan.survey_id
        return self._calls.call(lambda: self._storage.add_fact(survey_id, kind, values_json), check)

    def _note_stored(self, stored: int, index: int) -> None:
        self._survey.coverage.note_stored(index)
        visited = len(self._plan.stored_indices) + stored
        remaining_s = self._remaining.remaining_s(stored, self._elapsed_s())
        self._survey.status.update(visited_points=visited, remaining_s=remaining_s)

    def _elapsed_s(self) -> float:
        since_s = self._measuring_since_s
        if since_s is None:
            return self._measured_s
        return self._measured_s + self._survey.clock.now_s() - since_s


def interruption_remark(interrupted: str) -> Optional[Message]:
    """Return a remark on the survey that was still open when another began; None if none was."""
    if not interrupted:
        return None
    return Message(
        "survey {survey} was still open; it is closed as interrupted and can be resumed later",
        survey=interrupted,
    )


def _names(sensors: Sequence[Mapping[str, Any]]) -> str:
    return ", ".join(str(one.get("name")) for one in sensors) or "-"


def survey_record(
    plan: SurveyPlan, analyzer: AnalyzerState, robot: Mapping[str, Any]
) -> SurveyRecord:
    """Return what is recorded about a survey when it begins; of the robot, what its parts say."""
    metadata = {
        "simulated": plan.config.simulated,
        "parameters": asdict(plan.parameters),
        PLAN_ID: plan.parameters.plan_id,
        PLAN_SET_BY: plan.set_by,
        "planned_traces": plan.total_points,
        "estimated_duration_s": plan.duration_s,
        "instrument": {
            "identity": analyzer.identity,
            "address": plan.parameters.vna_address,
            "calibration_status": int(analyzer.calibration),
            "calibration": str(analyzer.calibration.meaning),
            "calibration_details": dict(analyzer.calibration_details),
            "sweep": _recorded_sweep(analyzer),
        },
        "axes": {axis_id.value: asdict(one) for axis_id, one in plan.config.axes.items()},
        "settings": plain(plan.settings),
        ANNOTATION: plan.annotation.values(),
        **({REFINES: plan.refines} if plan.refines else {}),
        **({PLANNED: plan.permittivity} if plan.permittivity is not None else {}),
        **robot,
    }
    size = needed_bytes(plan.total_points, plan.parameters.frequency_points, plan.duration_s)
    return SurveyRecord(plan.survey_id, time_of_day_us(), json.dumps(metadata), size)


def _recorded_sweep(analyzer: AnalyzerState) -> Dict[str, Any]:
    settings = asdict(analyzer.settings)
    receiver = settings.pop("analyzer")
    return {**settings, **receiver, "sweep_duration_s": analyzer.sweep_duration_s}
