"""What the tests of the storage share: traces, messages without ROS, a storage to fill."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable, Container, Dict, Iterable, List, Optional

from trace_examples import STARTED_US, SURVEY

from gpr20_analysis.read.recordings import Lost, all_messages
from gpr20_common.low.clock import Clock
from gpr20_survey.files.durable_files import Readers, ensure_folders
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.markers import Marker
from gpr20_survey.recording.bag import make_bag
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_survey.recording.survey_topics import TEXT, SurveyTopics, recorded_log
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_form import pack_text
from gpr20_vna_processing.mid.data_processing import DataProcessing
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters
from gpr20_vna_processing.mid.processing_records import ChangedSurvey, Storage, SurveyEnd

OTHER_SURVEY = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
NOW_NS = 1_790_000_100_000_000_001
FREE_BYTES = 10**12
# In the place of those processes; a test that needs a bag makes it.
NO_BAGS: Any = SimpleNamespace(
    make=lambda _: None,
    cancel=lambda _: None,
    outstanding_bytes=lambda: 0,
)
LIMITS = ProcessingParameters(timeout_s=60.0, commit_period_s=0.05)


def text_message(
    topic: str, text: str, time_ns: int = NOW_NS, latching: bool = False
) -> RecordedMessage:
    """Return a std_msgs/String for recording."""
    return RecordedMessage(topic, *TEXT, pack_text(text), time_ns, latching)


def bag_messages(path: Path) -> List[RecordedMessage]:
    """Return every message of a bag, which must be whole."""
    lost = Lost()
    found = list(all_messages(path, lost))
    assert lost == Lost()
    return found


def with_bag(folder: Path) -> Path:
    """Make the bag of a survey that has ended, as the node does; return its folder."""
    make_bag(folder)
    return folder


def end_status(end: SurveyEnd) -> RecordedMessage:
    """Return a text in the place of the last status, whose type these tests do not know."""
    return text_message(
        "/control_status", f"{end.state.name}: {end.message}", end.time_ns, latching=True
    )


class Kit:
    """A storage over a temporary folder and what it said."""

    def __init__(
        self,
        data: Path,
        open_recording: Callable[..., Any] = McapFile,
        limits: ProcessingParameters = LIMITS,
        free_bytes: int = FREE_BYTES,
        now_ns: int = NOW_NS,
        readers: Readers = Readers.GROUP,
        signing_key: str = "",
        check_data: Optional[Callable[[], None]] = None,
        bags: Any = NO_BAGS,
    ) -> None:
        self.stored: List[Trace] = []
        self.opened: List[str] = []
        self.logged: List[RecordedMessage] = []
        self.now_ns = now_ns
        parameters = replace(limits, data=str(data), readable_by=readers, signing_key=signing_key)
        self.processing = DataProcessing(
            Storage(
                parameters,
                check_data=check_data or (lambda: ensure_folders(data, readers.folder_mode)),
                open_recording=open_recording,
                topics=SurveyTopics(),
                free_bytes=lambda _: free_bytes,
                now_ns=lambda: self.now_ns,
                clock=Clock(),
                revision="1.2.3",
                end_status=end_status,
                publish=self._note,
                bags=bags,
            )
        )
        self.processing.start()

    def _note(self, message: RecordedMessage) -> None:
        if message.datatype == trace_message.DATATYPE:
            self.stored.append(trace_message.decode(message.data, message.md5sum))
        elif recorded_log(message) is not None:
            self.logged.append(message)
        else:
            self.opened.append(message.data[4:].decode())

    def open(self, survey_id: str = SURVEY, **changes: Any) -> Path:
        """Open a survey."""
        arguments = {"started_us": STARTED_US, "metadata_json": '{"simulated": true}'}
        return self.processing.open_survey(
            survey_id, **{**arguments, "needed_bytes": 1000, **changes}
        )

    def annotate(self, survey: str, annotation: Annotation) -> ChangedSurvey:
        """Replace the annotation of a survey."""
        return self._add_fact(survey, Kind.ANNOTATION, annotation.values())

    def add_marker(self, survey: str, marker: Marker) -> ChangedSurvey:
        """Add a marker to a survey."""
        return self._add_fact(survey, Kind.MARKER, marker.request())

    def remove_marker(self, survey: str, marker_id: str, author: str) -> ChangedSurvey:
        """Remove a marker of a survey."""
        values = {"marker_id": marker_id, "author": author}
        return self._add_fact(survey, Kind.MARKER_REMOVED, values)

    def report(self, survey: str, report_json: str) -> int:
        """Add a report to the open survey; return how many traces are stored."""
        return self.processing.add_fact(survey, "report", report_json).stored_traces

    def _add_fact(self, survey: str, kind: Kind, values: Dict[str, Any]) -> ChangedSurvey:
        return self.processing.add_fact(survey, kind.value, json.dumps(values))

    def finish(self, traces: Iterable[Trace], stored: Container[int]) -> None:
        """Store the traces whose indices are not stored, and finish the survey."""
        for trace in traces:
            if trace.index not in stored:
                self.processing.store(trace)
        self.processing.close_survey(SURVEY, "finished")
