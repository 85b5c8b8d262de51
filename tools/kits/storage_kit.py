"""What the tests of the storage share: traces, messages without ROS, a storage to fill, keys.

What it has recorded is read by readers that are not this project's.
"""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable, Container, Dict, Iterable, Iterator, List, Optional, Tuple

import zstandard
from mcap.exceptions import McapError
from mcap.reader import McapReader, NonSeekingReader, make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from trace_examples import STARTED_US, SURVEY

from gpr20_analysis.read.recordings import Lost, all_messages
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.jobs.pictures import StoredSurvey, SurveysListed, TracesRead
from gpr20_survey.files.durable_files import Readers, ensure_folders
from gpr20_survey.folder import signature
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.signature import NAMESPACE
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


TRACE = "gpr20_msgs/msg/Trace"


def bag_traces(path: Path) -> Iterator[Any]:
    """Yield the messages of the traces in a bag that has its index."""
    with AnyReader([path]) as reader:
        connections = [one for one in reader.connections if one.topic == "/trace"]
        # Without any, the reader would return every message.
        if connections:
            for connection, _time, raw in reader.messages(connections):
                yield reader.deserialize(raw, connection.msgtype)


def mcap_traces(path: Path) -> Iterator[Any]:
    """Yield the messages of the traces in an MCAP file that has ended."""
    with path.open("rb") as file:
        yield from _messages_of(make_reader(file, validate_crcs=True))


def torn_mcap_traces(path: Path) -> Iterator[Any]:
    """Yield the same, read forward, without the index, up to where the file was torn."""
    with path.open("rb") as file:
        try:
            yield from _messages_of(NonSeekingReader(file))
        except (McapError, EOFError, struct.error, ValueError, zstandard.ZstdError):
            # Torn here; what was acknowledged must have come before.
            return


def _messages_of(reader: McapReader) -> Iterator[Any]:
    types = get_typestore(Stores.ROS1_NOETIC)
    for schema, _channel, message in reader.iter_messages(["/trace"], log_time_order=False):
        if schema is not None and TRACE not in types.types:
            types.register(get_types_from_msg(schema.data.decode(), TRACE))
        yield types.deserialize_ros1(message.data, TRACE)


def make_key(path: Path, passphrase: str = "") -> None:
    """Make a key of the kind that `robot_config key` makes."""
    made = signature.ssh_keygen(
        ("-q", "-t", "ed25519", "-N", passphrase, "-C", "robot", "-f", path)
    )
    assert made.yes, made.complaint


def fingerprint(path: Path) -> str:
    """Return the fingerprint of a key."""
    return signature.use_key(path, ("-l",)).split()[1]


def signers_line(path: Path, signer: str = "robot") -> str:
    """Return the line of a signers file that accepts a key."""
    kind, key = signature.use_key(path, ("-y", "-P", "")).split()[:2]
    return f'{signer} namespaces="{NAMESPACE}" {kind} {key}\n'


NAMES = {Service.LIST: "list", Service.READ: "survey", Service.TRACES: "traces"}
ANSWERS = {SurveysListed: "list", StoredSurvey: "survey", TracesRead: "traces"}


class AskedStorage:
    """In place of the storage: it remembers what it was asked, and answers when a test says."""

    def __init__(self) -> None:
        self.asked: List[Tuple[Any, ...]] = []
        self._tickets: Dict[str, Ticket[Any]] = {}

    def of(self, kind: str) -> List[Tuple[Any, ...]]:
        """Return what was asked of a kind."""
        return [one[1:] for one in self.asked if one[0] == kind]

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        fields.pop("max_surveys", None)
        self._tickets[NAMES[service]] = ticket
        self.asked.append((NAMES[service], *fields.values()))

    def answer(self, found: Any) -> None:
        """Answer the last question of that kind."""
        self._tickets[ANSWERS[type(found)]].done(found)

    def fail(self, kind: str, reason: Message) -> None:
        """Refuse the last question of a kind."""
        self._tickets[kind].fail(reason)

    def cancel(self, _request_id: str) -> None:
        """Do nothing: nothing that is asked here can be ended."""
