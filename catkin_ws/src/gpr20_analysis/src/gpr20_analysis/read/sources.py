"""The sources of a survey: its folder, its JSON files, its bag or its MCAP file."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError, not_there
from gpr20_analysis.read import recordings
from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.faults import OTHER_VERSION
from gpr20_survey.files.regular_file import check_regular
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import LOG, Kind, LogRecord, add_to
from gpr20_survey.folder.recovery import recover
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

FACTS = (Kind.DECISION, Kind.CLOCK, Kind.DRIFT)
"""Kinds of the log's facts that no other entry of survey.json holds, but a reader needs."""
INDEX_IN_NAME = re.compile(r"(\d{6})_X")

Position = Tuple[float, float, float]
"""Rotation [deg], y and x [mm]."""


@dataclass(frozen=True)
class Damage:
    """Something that is damaged, and the sample that is lost by it, if that is known."""

    message: Message
    index: Optional[int] = None
    position: Optional[Position] = None


class JsonSource:
    """The JSON files of a survey.

    Attributes:
        name: Its name in messages.
        description: Content of survey.json, if it is there.
        count: Expected number of traces; 0 if unknown.
        faults: What is damaged in the part that `traces` has read.
        notes: What else a user should know.
    """

    def __init__(
        self,
        name: str,
        files: List[Path],
        description: Optional[Dict[str, Any]],
        read: Callable[[Path], Trace],
    ) -> None:
        """Make the source; `traces` reads the files, each with `read`."""
        self.name = storable(name)
        self.description = description
        self.count = len(files)
        self.faults: List[Damage] = []
        self.notes: List[Message] = []
        self._files = files
        self._read = read

    def traces(self) -> Iterator[Trace]:
        """Yield every intact trace; damaged ones are left out and named in `faults`."""
        for path in self._files:
            try:
                yield self._read(path)
            except (TraceRefusedError, OSError) as error:
                found = INDEX_IN_NAME.match(path.name)
                index = int(found.group(1)) if found else None
                reason = os_reason(error) if isinstance(error, OSError) else error.message
                message = Message("{file}: {reason}", file=path.name, reason=reason)
                self.faults.append(Damage(message, index))


class RecordingSource:
    """A bag or an MCAP file; its attributes are those of `JsonSource`."""

    def __init__(self, path: Path) -> None:
        """Open the recording.

        Raises:
            UnreadableFileError: It is neither.
            OSError: It cannot be read.
        """
        self._recording = recordings.open_recording(path)
        self._path = path
        self.name = storable(path.name)
        self.count = 0
        self.faults: List[Damage] = []
        self.notes: List[Message] = list(self._recording.notes)
        self.description = self._description(self._recording.metadata)

    def traces(self) -> Iterator[Trace]:
        """Yield every intact trace; damaged ones are left out and named in `faults`.

        Raises:
            UnreadableFileError: It is whole, but no recording of a survey.
        """
        number = -1
        try:
            for number, recorded in enumerate(self._recording.traces):
                try:
                    yield trace_message.decode(recorded.data, recorded.md5sum)
                except TraceRefusedError as error:
                    message = Message(
                        "{file}: recorded trace {number}: {reason}",
                        file=self.name,
                        number=number,
                        reason=error.message,
                    )
                    self.faults.append(Damage(message))
        except UnreadableFileError as error:
            message = Message(
                "{file} cannot be read to its end: {reason}", file=self.name, reason=error.message
            )
            self.faults.append(Damage(message))
        if number < 0 and not self.faults:
            raise recordings.without_traces(self._path)

    def _description(self, metadata: Optional[str]) -> Optional[Dict[str, Any]]:
        if metadata is None:
            return None
        try:
            found = survey_metadata.parse_object(metadata, f"survey.json in {self.name}")
            if found.get("format") != survey_metadata.FORMAT:
                raise SurveyRefusedError(
                    Message(
                        "the format of {file} is {found}; this software reads {expected}",
                        file=f"survey.json in {self.name}",
                        found=repr(found.get("format"))[:64],
                        expected=repr(survey_metadata.FORMAT),
                    ),
                    fault=OTHER_VERSION,
                )
            for record in self._recording.log:
                add_to(found, record)
            return whole_description(found, self._recording.log)
        except SurveyRefusedError as error:
            self.faults.append(Damage(error.message))
            return None


SurveySource = Union[JsonSource, RecordingSource]


def read_trace(path: Path) -> Trace:
    """Return the trace of a file.

    Raises:
        TraceRefusedError: It holds no whole trace.
        OSError: It cannot be read.
    """
    return trace_files.read_trace(path)


def open_source(path: Path, read: Callable[[Path], Trace] = read_trace) -> SurveySource:
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
    if recordings.is_recording(path):
        return RecordingSource(path)
    if path.suffix == ".json":
        return JsonSource(path.name, [path], None, read)
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


def _folder_source(folder: Path, read: Callable[[Path], Trace]) -> JsonSource:
    traces = folder / survey_folder.TRACES_FOLDER
    logs = [folder / name for name in survey_folder.LOG_FILES]
    for one in (traces, *logs):
        check_regular(one)
    files = _trace_files(traces if traces.is_dir() else folder)
    description, damage = None, []
    is_described = any(one.exists() for one in logs)
    if is_described:
        try:
            recovered = recover(folder)
            description = whole_description(recovered.description, recovered.found.records)
        except SurveyRefusedError as error:
            damage.append(Damage(error.message))
    if not files and is_described:
        raise AnalysisError(
            Message(
                "{folder} holds a survey without traces; resume it, or choose another",
                folder=folder,
            ),
            fault=faults.INPUT,
        )
    if not files:
        raise AnalysisError(
            Message(
                "{folder} contains no survey: there are no JSON files of traces in it or in its "
                "folder {traces}/",
                folder=folder,
                traces=survey_folder.TRACES_FOLDER,
            ),
            fault=faults.INPUT,
        )
    source = JsonSource(folder.name, files, description, read)
    source.faults += damage
    return source


def _trace_files(folder: Path) -> List[Path]:
    with os.scandir(str(folder)) as entries:
        names = [entry.name for entry in entries if entry.name.endswith(".json")]
    return [folder / name for name in sorted(names) if name != survey_folder.SURVEY_FILE]
