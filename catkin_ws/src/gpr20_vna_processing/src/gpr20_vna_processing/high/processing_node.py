"""The node vna_processing: services to open, fill and close a survey on the disk."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import Any, List

import rospy
from std_msgs.msg import String

from gpr20_common.errors import os_reason
from gpr20_common.faults import DISK_FULL, DISK_REFUSES, DISK_SLOW
from gpr20_common.high.answers import advertise, fault_of, fields_of, message_fields, received
from gpr20_common.high.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from gpr20_common.high.graph_keeper import subscriber_count
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.raw_message import deserialized, microseconds, preserialized, serialized
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.node_facts import NO_HARDWARE, software_revision
from gpr20_common.terminal_text import printable
from gpr20_msgs import srv
from gpr20_msgs.msg import SurveySummary, Trace
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.folder.data_folder import DataFolder, existing_folder
from gpr20_survey.folder.signature import key_warning
from gpr20_survey.plan.robot_description import SENSORS, Sensors
from gpr20_survey.recording import survey_topics
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import block_fields
from gpr20_vna_processing.high.recorded_messages import (
    TopicRecorder,
    end_messages,
    end_status,
    wait_for_nodes,
)
from gpr20_vna_processing.low.bag_processes import BagProcesses
from gpr20_vna_processing.mid.data_processing import DataProcessing
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB, ProcessingParameters
from gpr20_vna_processing.mid.processing_records import Storage
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys

NODE = "vna_processing"
MAX_REPAIRS_SHOWN = 10
BAGS_LIMIT_S = 8.0  # of the 15 s that roslaunch gives a node to end


class ProcessingNode:
    """Turns requests into calls of DataProcessing and StoredSurveys, and answers into messages."""

    def __init__(self, parameters: ProcessingParameters, sensors: Sensors) -> None:
        """Connect everything; nothing is recorded before `open_survey`."""
        self._data = parameters.data_folder()
        self._folder = DataFolder(parameters.data_folder_use())
        self._reserve_bytes = parameters.disk_reserve_bytes
        self._trace = rospy.Publisher(survey_topics.TRACE_TOPIC, Trace, queue_size=100)
        metadata = rospy.Publisher(survey_topics.METADATA_TOPIC, String, queue_size=1, latch=True)
        log = rospy.Publisher(survey_topics.LOG_TOPIC, String, queue_size=100)
        own = zip(survey_topics.OWN_TOPICS, (self._trace, metadata, log))
        self._publishers = {rospy.resolve_name(name): one for name, one in own}
        self._bags = BagProcesses(free_bytes, self._reserve_bytes)
        self._key_warning = key_warning(parameters.signer())
        self._processing = DataProcessing(
            Storage(
                parameters,
                check_data=self._folder.check,
                topics=survey_topics.SurveyTopics(rospy.resolve_name),
                free_bytes=free_bytes,
                now_ns=time.time_ns,
                clock=Clock(),
                revision=software_revision(),
                end_status=end_status,
                bags=self._bags,
                publish=self._publish,
            )
        )
        self._processing.start()
        rospy.on_shutdown(self._shut_down)
        topics = (*parameters.all_topics, *sensors.topics)
        self._recorder = TopicRecorder(topics, self._processing.record)
        self._surveys = StoredSurveys(self._data)
        self._services = [
            advertise("open_survey", srv.OpenSurvey, self._open_survey),
            advertise("reopen_survey", srv.ReopenSurvey, self._reopen_survey),
            advertise("add_fact", srv.AddFact, self._add_fact),
            advertise("store_data", srv.StoreData, self._store_data),
            advertise("close_survey", srv.CloseSurvey, self._close_survey),
            advertise("list_surveys", srv.ListSurveys, self._list_surveys),
            advertise("read_survey", srv.ReadSurvey, self._read_survey),
            advertise("read_traces", srv.ReadTraces, self._read_traces),
        ]
        self._diagnostics = Diagnostics("storage", self._health)
        self._description = publish_description(NODE, NO_HARDWARE, parameters)

    def _open_survey(self, request: Any) -> Any:
        interrupted = self._before_opening(request, request.survey_id)
        folder = self._processing.open_survey(
            request.survey_id,
            microseconds(request.started),
            request.metadata_json,
            request.needed_bytes,
        )
        place = printable(folder)
        message = Message(
            "survey {survey} is open in {folder}", survey=request.survey_id, folder=place
        )
        return success(srv.OpenSurvey, message, path=str(folder), interrupted=interrupted)

    def _reopen_survey(self, request: Any) -> Any:
        interrupted = self._before_opening(request, request.survey)
        # Reopening publishes the last trace again, maybe as the first act of this process.
        wait_for_nodes(self._unheard, "a subscriber of %s is not connected")
        reopened = self._processing.reopen_survey(request.survey)
        recent = [deserialized(Trace, trace_message.encode(one)) for one in reopened.recent]
        message = Message(
            "survey {survey} is open again with {stored} traces stored",
            survey=reopened.survey_id,
            stored=len(reopened.stored_indices),
        )
        again = replace(reopened, interrupted=interrupted)
        return success(
            srv.ReopenSurvey,
            in_a_row([message, *reopened.repairs[:MAX_REPAIRS_SHOWN]]),
            **{**fields_of(again, srv.ReopenSurveyResponse), "recent": recent},
        )

    def _before_opening(self, request: Any, survey: str) -> str:
        interrupted = self._processing.interrupt_other(survey) if request.interrupt_open else ""
        warning = "recording begins without a publisher of %s"
        wait_for_nodes(lambda: self._recorder.unconnected(), warning)
        return interrupted

    def _unheard(self) -> List[str]:
        topic = self._trace.resolved_name
        return [topic] if self._trace.get_num_connections() < subscriber_count(topic) else []

    def _add_fact(self, request: Any) -> Any:
        added = self._processing.add_fact(request.survey, request.kind, request.values_json)
        message = Message("the log of survey {survey} has the fact", survey=added.survey_id)
        return success(
            srv.AddFact,
            message,
            survey_id=added.survey_id,
            stored_traces=added.stored_traces,
            markers_json=json.dumps(added.markers) if added.markers else "",
        )

    def _store_data(self, request: Any) -> Any:
        # The request holds nothing but the trace, so their bytes are the same.
        trace = trace_message.decode(serialized(request))
        path = self._processing.store(trace)
        message = Message("{trace} is stored", trace=trace.label)
        return success(srv.StoreData, message, path=str(path))

    def _close_survey(self, request: Any) -> Any:
        reason = received(request.reason, request.reason_fault)
        end = end_messages(request, time.time_ns())
        closed = self._processing.close_survey(request.survey_id, request.outcome, reason, end)
        message = Message(
            "survey {survey} is closed with {stored} traces",
            survey=closed.survey_id,
            stored=closed.stored_traces,
        )
        unsigned = self._processing.state().unsigned
        if unsigned is not None:
            message = in_a_row([message, unsigned])
        return success(srv.CloseSurvey, message)

    def _list_surveys(self, request: Any) -> Any:
        surveys, more = self._surveys.list(request.before, request.max_surveys)
        return success(
            srv.ListSurveys,
            Message("{count} surveys", count=len(surveys)),
            surveys=[SurveySummary(**fields_of(one, SurveySummary)) for one in surveys],
            more=more,
        )

    def _read_survey(self, request: Any) -> Any:
        survey = self._surveys.survey(request.survey)
        return success(
            srv.ReadSurvey,
            Message("{count} traces stored", count=len(survey.stored_indices)),
            metadata_json=json.dumps(survey.description),
            stored_indices=survey.stored_indices,
        )

    def _read_traces(self, request: Any) -> Any:
        block, unreadable = self._surveys.traces(request.survey, request.indices)
        message = Message(
            "{count} traces, {unreadable} files cannot be read",
            count=len(block.indices),
            unreadable=len(unreadable),
        )
        return success(
            srv.ReadTraces,
            message,
            **block_fields(block),
            unreadable=[f"{index}: {reason}" for index, reason in unreadable.items()],
            unreadable_faults=[*map(fault_of, unreadable.values())],
        )

    def _shut_down(self) -> None:
        try:
            self._processing.shut_down()
        except ProcessingError as error:
            rospy.logerr("the survey could not be finished: %s", error)
        self._bags.stop(BAGS_LIMIT_S)

    def _health(self) -> Health:
        state = self._processing.state()
        problem = self._folder.problem()
        if problem is not None and not state.failing:
            # Without a size: it would be that of another disk.
            return ERROR, problem, {"open survey": state.survey_id, "folder": state.folder}
        try:
            # The data folder may not be there before the first survey.
            free_mb = free_bytes(existing_folder(self._data)) / BYTES_PER_MB
        except OSError as error:
            message = Message(
                "the free space on the disk of {path} is unknown: {reason}",
                path=printable(self._data),
                reason=os_reason(error),
            ).with_fault(DISK_REFUSES)
            return ERROR, message, {}
        values = {
            "open survey": state.survey_id,
            "folder": state.folder,
            "traces stored": state.stored_traces,
            "free disk [MB]": free_mb,
            "stores waiting": state.queues.jobs,
            "messages waiting": state.queues.messages,
            "messages dropped": state.unrecorded,
            "last error": state.last_error or "",
        }
        if state.failing and state.last_error is not None:
            return ERROR, state.last_error, values
        if free_mb * BYTES_PER_MB < self._reserve_bytes:
            message = Message(
                "only {free_mb:.0f} MB are free on the disk; make space", free_mb=free_mb
            )
            return WARN, message.with_fault(DISK_FULL).as_warning(), values
        if state.unrecorded:
            message = Message("messages of other topics were dropped; the disk is too slow")
            return WARN, message.with_fault(DISK_SLOW).as_warning(), values
        warning = state.unsigned or self._key_warning or self._bags.problem()
        if warning is not None:
            return WARN, warning, values
        if not state.survey_id:
            return OK, Message("no survey is open"), values
        return OK, Message("{count} traces stored", count=state.stored_traces), values

    def _publish(self, message: RecordedMessage) -> None:
        publisher = self._publishers[message.topic]
        try:
            kind = Trace if message.datatype == trace_message.DATATYPE else String
            publisher.publish(preserialized(kind, message.data))
        except rospy.ROSException as error:
            # ROS is shutting down; what was stored is durable, as the answer states.
            rospy.logwarn("%s: stored but not published: %s", publisher.name, error)


def success(service_class: Any, message: Message, **fields: Any) -> Any:
    return service_class._response_class(success=True, **message_fields(message), **fields)


def main() -> None:
    """Run the node."""
    run_node(
        NODE,
        lambda: ProcessingNode(
            read_parameters(ProcessingParameters, "storage"), read_parameters(Sensors, SENSORS)
        ),
    )
