"""The sources of a survey: its folder, the folder of its JSON files, its bag or its MCAP file."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence

from gpr20_analysis import errors
from gpr20_analysis.errors import AnalysisError, not_there
from gpr20_analysis.read.recordings import (
    Lost,
    all_messages,
    is_metadata_topic,
    is_recording,
    without_traces,
)
from gpr20_common.errors import os_reason
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import storable
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.faults import OTHER_VERSION
from gpr20_survey.files.regular_files import check_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import LOG, Kind, LogRecord, add_to
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.recording.survey_topics import TEXT_TYPE, recorded_log
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

FACTS = (Kind.DECISION, Kind.CLOCK, Kind.DRIFT)
"""Kinds of the log's facts that no other entry of survey.json holds, but a reader needs."""
OF_SURVEY = (survey_folder.SURVEY_FILE, MANIFEST_FILE)
"""JSON files of a survey that are no traces."""
INDEX_IN_NAME = re.compile(r"(\d{6})_X")

ReadTrace = Callable[[Path], Trace]


@dataclass(frozen=True)
class Damage:
    """Something that is damaged, and the index of the trace that is lost by it, if known."""

    message: Message
    index: Optional[int] = None


@dataclass
class Source:
    """What holds a survey.

    Attributes:
        name: Its name in messages.
        traces: Yields every intact trace; damaged ones are left out and named in `faults`.
        description: What its log says of the survey, if it is there.
        count: Expected number of traces; None if unknown.
        faults: What is damaged in the part that was read.
        notes: What else a user should know.
    """

    name: str
    traces: Callable[[], Iterator[Trace]]
    description: Optional[Dict[str, Any]] = None
    count: Optional[int] = None
    faults: List[Damage] = field(default_factory=list)
    notes: List[Message] = field(default_factory=list)


def open_source(path: Path, read: ReadTrace = read_trace) -> Source:
    """Return the source at a path.

    Args:
        path: Folder of a survey, folder of its trace files, bag or MCAP file.
        read: Reads a trace file.

    Raises:
        AnalysisError: It is none of these.
        OSError: It cannot be read.
    """
    if path.is_dir():
        return _folder_source(path, read)
    if not path.exists():
        raise AnalysisError(not_there(path), fault=errors.INPUT)
    if is_recording(path):
        return _recording_source(path)
    raise AnalysisError(
        Message(
            "{path} is not a survey; give its folder, the folder of its JSON files, its .bag or "
            "its .mcap; `gpr20 import` reads other formats",
            path=path,
        ),
        fault=errors.INPUT,
    )


def whole_description(described: Dict[str, Any], records: Sequence[LogRecord]) -> Dict[str, Any]:
    """Return what a log says, with those of its records that a reader needs beside it."""
    return {**described, LOG: [one.as_json() for one in records if one.kind in FACTS]}


def _folder_source(folder: Path, read: ReadTrace) -> Source:
    traces = folder / survey_folder.TRACES_FOLDER
    logs = [folder / name for name in survey_folder.LOG_FILES]
    for one in (traces, *logs):
        check_regular(one)
    place = traces if traces.is_dir() else folder
    names = [one.name for one in place.iterdir() if one.name.endswith(".json")]
    files = sorted(place / one for one in names if one not in OF_SURVEY)
    is_described = any(one.exists() for one in logs)
    recording = folder / survey_folder.MCAP_FILE
    if not files and recording.exists():
        raise AnalysisError(
            Message(
                "the folder {traces}/ of {folder} has no traces; give {recording}, which has them "
                "too",
                traces=survey_folder.TRACES_FOLDER,
                folder=folder,
                recording=recording,
            ),
            fault=errors.INPUT,
        )
    if not files:
        raise AnalysisError(
            Message(
                "{folder} holds no traces of a survey: there are no JSON files in it or in its "
                "folder {traces}/; choose another, or resume the survey",
                folder=folder,
                traces=survey_folder.TRACES_FOLDER,
            ),
            fault=errors.INPUT,
        )
    found = Source(storable(folder.name), lambda: _of_files(files, read, found), count=len(files))
    if is_described:
        try:
            recovered = recover(folder)
            found.description = whole_description(recovered.description, recovered.found.records)
        except SurveyRefusedError as error:
            found.faults.append(Damage(error.message))
    return found


def _of_files(files: Sequence[Path], read: ReadTrace, source: Source) -> Iterator[Trace]:
    for path in files:
        try:
            yield read(path)
        except (TraceRefusedError, OSError) as error:
            number = INDEX_IN_NAME.match(path.name)
            reason = os_reason(error) if isinstance(error, OSError) else error.message
            message = Message("{file}: {reason}", file=path.name, reason=reason)
            source.faults.append(Damage(message, int(number[1]) if number else None))


def _recording_source(path: Path) -> Source:
    recording = path.resolve()  # a link that is named is followed
    found = Source(storable(path.name), lambda: _of_recording(recording, found))
    lost, texts, records = Lost(), [], []
    for one in all_messages(recording, lost, TEXT_TYPE):
        record = recorded_log(one)
        if is_metadata_topic(one.topic):
            texts.append(one.data[4:].decode("utf-8", "replace"))
        elif record is not None:
            records.append(record)
    found.notes += lost.missing
    if texts:
        try:
            found.description = _recorded_description(texts[0], records, found.name)
        except SurveyRefusedError as error:
            found.faults.append(Damage(error.message))
    return found


def _recorded_description(text: str, records: Sequence[LogRecord], name: str) -> Dict[str, Any]:
    file = f"survey.json in {name}"
    described = survey_metadata.parse_object(text, file)
    if described.get("format") != survey_metadata.FORMAT:
        raise SurveyRefusedError(
            Message(
                "the format of {file} is {found}; this software reads {expected}",
                file=file,
                found=repr(described.get("format"))[:64],
                expected=repr(survey_metadata.FORMAT),
            ),
            fault=OTHER_VERSION,
        )
    for record in records:
        add_to(described, record)
    return whole_description(described, records)


def _of_recording(path: Path, source: Source) -> Iterator[Trace]:
    lost, number = Lost(), -1
    for number, one in enumerate(all_messages(path, lost, trace_message.DATATYPE)):
        try:
            yield trace_message.decode(one.data, one.md5sum)
        except TraceRefusedError as error:
            message = Message(
                "{file}: recorded trace {number}: {reason}",
                file=source.name,
                number=number,
                reason=error.message,
            )
            source.faults.append(Damage(message))
    if lost.faults:
        reason = in_a_row(lost.faults).reporting_only(errors.FILE_DAMAGED)
        message = Message(
            "{file} cannot be read to its end: {reason}", file=source.name, reason=reason
        )
        source.faults.append(Damage(message))
    if number < 0 and not source.faults:
        raise without_traces(path)
