"""The sources of a survey: its folder, its JSON files, its bag or its MCAP file."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

from gpr20_analysis import faults
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
from gpr20_survey.files.regular_file import check_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import LOG, Kind, LogRecord, add_to
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.recording.survey_topics import TEXT_TYPE, recorded_log
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

FACTS = (Kind.DECISION, Kind.CLOCK, Kind.DRIFT)
"""Kinds of the log's facts that no other entry of survey.json holds, but a reader needs."""
INDEX_IN_NAME = re.compile(r"(\d{6})_X")

Position = Tuple[float, float, float]
"""Rotation [deg], y and x [mm]."""
ReadTrace = Callable[[Path], Trace]


@dataclass(frozen=True)
class Damage:
    """Something that is damaged, and the sample that is lost by it, if that is known."""

    message: Message
    index: Optional[int] = None
    position: Optional[Position] = None


class SurveySource:
    """What holds a survey.

    Attributes:
        name: Its name in messages.
        description: What its log says of the survey, if it is there.
        count: Expected number of traces; 0 if unknown.
        faults: What is damaged in the part that `traces` has read.
        notes: What else a user should know.
    """

    def __init__(
        self, name: str, description: Optional[Dict[str, Any]] = None, count: int = 0
    ) -> None:
        self.name, self.description, self.count = name, description, count
        self.faults: List[Damage] = []
        self.notes: List[Message] = []

    def traces(self) -> Iterator[Trace]:
        """Yield every intact trace; damaged ones are left out and named in `faults`."""
        raise NotImplementedError


class JsonSource(SurveySource):
    """The JSON files of a survey, each read by a function."""

    def __init__(
        self,
        name: str,
        files: List[Path],
        read: ReadTrace,
        description: Optional[Dict[str, Any]] = None,
    ) -> None:
        super().__init__(name, description, len(files))
        self._files, self._read = files, read

    def traces(self) -> Iterator[Trace]:
        for path in self._files:
            try:
                yield self._read(path)
            except (TraceRefusedError, OSError) as error:
                found = INDEX_IN_NAME.match(path.name)
                index = int(found.group(1)) if found else None
                reason = os_reason(error) if isinstance(error, OSError) else error.message
                message = Message("{file}: {reason}", file=path.name, reason=reason)
                self.faults.append(Damage(message, index))


class RecordingSource(SurveySource):
    """A bag or an MCAP file."""

    def __init__(self, path: Path) -> None:
        """Read what the recording says of the survey.

        Raises:
            UnreadableFileError: It is neither.
            OSError: It cannot be read.
        """
        super().__init__(storable(path.name))
        self._path = path
        lost, texts, records = Lost(), [], []
        for one in all_messages(path, lost, TEXT_TYPE):
            record = recorded_log(one)
            if is_metadata_topic(one.topic):
                texts.append(one.data[4:].decode("utf-8", "replace"))
            elif record is not None:
                records.append(record)
        self.notes += lost.missing
        if texts:
            self._describe(texts[0], records)

    def traces(self) -> Iterator[Trace]:
        lost, number = Lost(), -1
        recorded = all_messages(self._path, lost, trace_message.DATATYPE)
        for number, one in enumerate(recorded):
            try:
                yield trace_message.decode(one.data, one.md5sum)
            except TraceRefusedError as error:
                message = Message(
                    "{file}: recorded trace {number}: {reason}",
                    file=self.name,
                    number=number,
                    reason=error.message,
                )
                self.faults.append(Damage(message))
        if lost.faults:
            reason = in_a_row(lost.faults).reporting_only(faults.FILE_DAMAGED)
            message = Message(
                "{file} cannot be read to its end: {reason}", file=self.name, reason=reason
            )
            self.faults.append(Damage(message))
        if number < 0 and not self.faults:
            raise without_traces(self._path)

    def _describe(self, text: str, records: Sequence[LogRecord]) -> None:
        file = f"survey.json in {self.name}"
        try:
            found = survey_metadata.parse_object(text, file)
            if found.get("format") != survey_metadata.FORMAT:
                raise SurveyRefusedError(
                    Message(
                        "the format of {file} is {found}; this software reads {expected}",
                        file=file,
                        found=repr(found.get("format"))[:64],
                        expected=repr(survey_metadata.FORMAT),
                    ),
                    fault=OTHER_VERSION,
                )
            for record in records:
                add_to(found, record)
            self.description = whole_description(found, records)
        except SurveyRefusedError as error:
            self.faults.append(Damage(error.message))


def open_source(path: Path, read: ReadTrace = read_trace) -> SurveySource:
    """Return the source at a path.

    Args:
        path: Folder of a survey, folder of its trace files, one trace file, bag or MCAP file.
        read: Reads a trace file.

    Raises:
        AnalysisError: It is none of these.
        OSError: It cannot be read.
    """
    if path.is_dir():
        return _folder_source(path, read)
    if not path.exists():
        raise AnalysisError(not_there(path), fault=faults.INPUT)
    if is_recording(path):
        return RecordingSource(path)
    if path.suffix == ".json":
        return JsonSource(storable(path.name), [path], read)
    raise AnalysisError(
        Message(
            "{path} is not a survey; give its folder, the folder of its JSON files, its .bag or "
            "its .mcap; `gpr20 import` reads other formats",
            path=path,
        ),
        fault=faults.INPUT,
    )


def whole_description(described: Dict[str, Any], records: Sequence[LogRecord]) -> Dict[str, Any]:
    """Return what a log says, with those of its records that a reader needs beside it."""
    return {**described, LOG: [one.as_json() for one in records if one.kind in FACTS]}


def _folder_source(folder: Path, read: ReadTrace) -> JsonSource:
    traces = folder / survey_folder.TRACES_FOLDER
    logs = [folder / name for name in survey_folder.LOG_FILES]
    for one in (traces, *logs):
        check_regular(one)
    with os.scandir(str(traces if traces.is_dir() else folder)) as entries:
        files = [Path(one.path) for one in entries if one.name.endswith(".json")]
    files = sorted(one for one in files if one.name != survey_folder.SURVEY_FILE)
    is_described = any(one.exists() for one in logs)
    if not files:
        message = (
            Message(
                "{folder} holds a survey without traces; resume it, or choose another",
                folder=folder,
            )
            if is_described
            else Message(
                "{folder} contains no survey: there are no JSON files of traces in it or in its "
                "folder {traces}/",
                folder=folder,
                traces=survey_folder.TRACES_FOLDER,
            )
        )
        raise AnalysisError(message, fault=faults.INPUT)
    source = JsonSource(storable(folder.name), files, read)
    if is_described:
        try:
            recovered = recover(folder)
            source.description = whole_description(recovered.description, recovered.found.records)
        except SurveyRefusedError as error:
            source.faults.append(Damage(error.message))
    return source
