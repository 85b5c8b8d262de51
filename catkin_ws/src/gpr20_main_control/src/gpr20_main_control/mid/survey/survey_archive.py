"""One survey in the storage: its folder, its traces, its facts and its end."""

from __future__ import annotations

import json
import threading
from collections import deque
from dataclasses import asdict
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Callable, Deque, Dict, Mapping, Optional, Tuple

from gpr20_common.faults import DISK_REFUSES
from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain
from gpr20_main_control.errors import DeviceError, message_of
from gpr20_main_control.mid.devices.robot import STORAGE_LIMIT_S, Storage, SurveyEnd, SurveyRecord
from gpr20_main_control.mid.survey.sampling import AnalyzerState
from gpr20_main_control.mid.survey.survey_plan import PLAN_ID, PLAN_SET_BY, SurveyPlan
from gpr20_main_control.mid.survey.survey_status import Status
from gpr20_main_control.mid.waits import Check
from gpr20_survey.folder.log_record import PLANNED_PERMITTIVITY, Kind
from gpr20_survey.folder.survey_metadata import message_record
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.recorded_plan import REFINES
from gpr20_survey.plan.robot_description import SENSORS, STORAGE_NAME
from gpr20_survey.plan.survey_points import SurveyPoint, needed_bytes
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import iso_text

if TYPE_CHECKING:  # the survey has this archive
    from gpr20_main_control.mid.survey.survey import Survey

# Traces that may wait for the disk; if there are more, the survey waits.
CAPACITY = 4
ATTEMPTS = 3
RETRY_S = 1.0
POLL_S = 0.1


class StorageQueue:
    """Stores traces one after another in a thread of its own: the next move need not wait.

    A trace leaves the queue only when it is stored durably. After a failure all traces stay in
    the queue until `retry` is called.
    """

    def __init__(self, storage: Storage, clock: Clock, on_stored: Callable[[int], None]) -> None:
        """Start the thread; `on_stored` is called with the index of each trace that is stored."""
        self._storage = storage
        self._clock = clock
        self._on_stored = on_stored
        self._changed = threading.Condition()
        self._traces: Deque[Trace] = deque()
        self._failure: Optional[Exception] = None
        self._retries = 0
        self._closing = threading.Event()
        threading.Thread(target=self._work, name="storage queue", daemon=True).start()

    @property
    def waiting(self) -> int:
        """Number of traces that are not stored durably yet."""
        return len(self._traces)

    def add(self, trace: Trace) -> None:
        """Accept a trace; it will be stored whatever the survey does next."""
        with self._changed:
            self._traces.append(trace)
            self._changed.notify_all()

    def wait_until_left(self, traces: int, check: Check) -> None:
        """Return when at most so many traces wait for the disk, or raise a DeviceError."""
        with self._changed:
            while len(self._traces) > traces and self._failure is None:
                check()
                self._changed.wait(POLL_S)
            if self._failure is not None:
                raise DeviceError(
                    Message(
                        "trace {index} could not be stored: {reason}",
                        index=self._traces[0].index,
                        reason=message_of(self._failure),
                    ),
                    fault=DISK_REFUSES,
                ) from self._failure

    def retry(self) -> None:
        """Clear a failure and try again with the trace that failed."""
        with self._changed:
            self._failure = None
            self._retries += 1
            self._changed.notify_all()

    def close(self) -> None:
        """End the thread; traces that are not stored yet are dropped."""
        self._closing.set()
        with self._changed:
            self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(
                    lambda: self._closing.is_set() or (self._traces and self._failure is None)
                )
                if self._closing.is_set():
                    return
                trace, retries = self._traces[0], self._retries
            failure = self._store(trace)
            if self._closing.is_set():
                # The queue is closed, and another survey may have begun.
                return
            if failure is None:
                # Announced before the trace leaves: an empty queue means that all are announced.
                # Whatever fails here, the trace is stored and must not be sent again. Without it in
                # the coverage the survey does not end as complete, and can be resumed.
                with faults_logged("storage queue"):
                    self._on_stored(trace.index)
            with self._changed:
                if failure is None:
                    self._traces.popleft()
                elif retries == self._retries:
                    # One that began before a retry says nothing about it.
                    self._failure = failure
                self._changed.notify_all()

    def _store(self, trace: Trace) -> Optional[Exception]:
        failure: Optional[Exception] = None
        for _attempt in range(ATTEMPTS):
            try:
                self._storage.store(trace)
                return None
            except Exception as error:
                # Faults in the software too: they must not leave the survey waiting for ever.
                failure = error
            if self._clock.wait_s(self._closing, RETRY_S):
                break
        return failure


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
        self.folder = plan.reopened.path
        self._facts: Deque[Tuple[Kind, Dict[str, Any]]] = deque()
        self._report = ""
        self._stored_traces = 0
        self._record: Optional[Tuple[object, SurveyRecord]] = None
        self._sensors = robot.sensors.recorded()
        self._durations_s = plan.pending_durations_s
        self.queue = StorageQueue(robot.storage, survey.clock, self._note_stored)

    def open(self, analyzer: AnalyzerState, check: Check) -> None:
        """Make the survey's folder and begin its recordings, or reopen them.

        The storage may have been restarted since; reopening an open survey changes nothing.
        """
        if self.folder:
            self.reopen(check)
            self.send_facts(check)
        else:
            record = self._record_with(analyzer)
            self.folder = self._calls.call(lambda: self._storage.open(record), check)

    def reopen(self, check: Check) -> None:
        """Reopen the survey in the storage; if it is open, nothing changes."""
        name = PurePosixPath(self.folder).name
        self._calls.call(lambda: self._storage.reopen(name), check)

    def wait_until_left(self, traces: int, point: SurveyPoint) -> None:
        """Return when at most so many traces, up to that of a point, wait for the disk."""
        action = Message("traces up to point {index}", index=point.index)
        longest_s = ATTEMPTS * (STORAGE_LIMIT_S + RETRY_S)
        with self._survey.waits.shown(STORAGE_NAME, action, longest_s) as check:
            self.queue.wait_until_left(traces, check)

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

    def send_report(self, check: Check, ended: bool = False) -> int:
        """Store the facts and the report, if it has changed; return how many traces are stored."""
        report_json = self._survey.report.to_json(ended)
        # Once: a survey that was closed by a call whose answer was lost accepts no report.
        if report_json != self._report:
            self.send_facts(check)
            self._stored_traces = self._send(Kind.REPORT, report_json, check)
            self._report = report_json
        return self._stored_traces

    def close(self, outcome: str, reason: Message, status: Status, check: Check) -> None:
        """Close the survey with one word for survey.json, why it ended, and its last status."""
        end = SurveyEnd(outcome, reason, status, self._survey.coverage)
        self._calls.call(lambda: self._storage.close(self._plan.survey_id, end), check)

    def _record_with(self, analyzer: AnalyzerState) -> SurveyRecord:
        # The same record again if the answer to the first call was lost: the storage knows it.
        key = analyzer.identity, analyzer.calibration.status, analyzer.setup.settings
        if self._record is None or self._record[0] != key:
            recorded = {**self._survey.robot.description.recorded(), SENSORS: self._sensors}
            self._record = key, survey_record(self._plan, analyzer, recorded)
        return self._record[1]

    def _send(self, kind: Kind, values_json: str, check: Check) -> int:
        survey_id = self._plan.survey_id
        return self._calls.call(lambda: self._storage.add_fact(survey_id, kind, values_json), check)

    def _note_stored(self, index: int) -> None:
        self._survey.coverage.note_stored(index)
        visited = self._survey.status.status.visited_points + 1
        stored = visited - len(self._plan.reopened.stored_indices)
        remaining_s = sum(self._durations_s[stored:])
        self._survey.status.update(visited_points=visited, remaining_s=remaining_s)


def survey_record(
    plan: SurveyPlan, analyzer: AnalyzerState, robot: Mapping[str, Any]
) -> SurveyRecord:
    """Return what is recorded about a survey when it begins; of the robot, what its parts say."""
    calibration, settings = analyzer.calibration, asdict(analyzer.setup.settings)
    sweep = {**settings.pop("analyzer"), **settings}
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
            "calibration_status": int(calibration.status),
            "calibration": str(calibration.status.meaning),
            "calibration_details": dict(calibration.details),
            "sweep": {**sweep, "sweep_duration_s": analyzer.setup.sweep_duration_s},
        },
        "axes": {axis_id.value: asdict(one) for axis_id, one in plan.config.axes.items()},
        "settings": plain(plan.settings),
        ANNOTATION: plan.annotation.values(),
        **({REFINES: plan.refines} if plan.refines else {}),
        **({PLANNED_PERMITTIVITY: plan.permittivity} if plan.permittivity is not None else {}),
        **robot,
    }
    size = needed_bytes(plan.total_points, plan.parameters.frequency_points, plan.duration_s)
    return SurveyRecord(plan.survey_id, time_of_day_us(), json.dumps(metadata), size)
