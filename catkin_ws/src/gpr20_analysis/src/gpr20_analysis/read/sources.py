"""Opens what holds a survey: its folder, its JSON files, its bag or its MCAP."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import orjson

from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.read import recordings
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.trace import trace_json, trace_message
from gpr20_survey.trace.trace import Trace

INDEX_IN_NAME = re.compile(r"(\d{6})_X")

Position = Tuple[float, float, float]
"""Rotation [deg], y and x [mm]."""


@dataclass(frozen=True)
class Fault:
    """Something that is damaged, and the sample that is lost by it, if it can be told."""

    text: str
    index: Optional[int] = None
    position: Optional[Position] = None


class JsonSource:
    """The JSON files of a survey.

    Attributes:
        name: What it is called, for messages.
        description: Content of survey.json, if it comes with the traces.
        count: How many traces it seems to hold; 0 if that cannot be told.
        faults: What is damaged, as far as `traces` has come.
        notes: What else should be known.
    """

    def __init__(self, name: str, files: List[Path], description: Optional[Dict[str, Any]]) -> None:
        """Take the files; they are read by `traces`."""
        self.name = name
        self.description = description
        self.count = len(files)
        self.faults: List[Fault] = []
        self.notes: List[str] = []
        self._files = files

    def traces(self) -> Iterator[Trace]:
        """Yield every whole trace; what is damaged is left out and named in `faults`."""
        for path in self._files:
            try:
                yield trace_files.read_trace(path, decode=_decode)
            except (TraceRefusedError, OSError) as error:
                found = INDEX_IN_NAME.match(path.name)
                index = int(found.group(1)) if found else None
                self.faults.append(Fault(f"{path.name}: {error}", index))


class RecordingSource:
    """A bag or an MCAP file; its attributes are those of `JsonSource`."""

    def __init__(self, path: Path) -> None:
        """Open the recording.

        Raises:
            UnreadableFileError: It is none.
            OSError: It cannot be read.
        """
        self._recording = recordings.open_recording(path)
        self.name = path.name
        self.count = self._recording.count
        self.faults: List[Fault] = []
        self.notes: List[str] = list(self._recording.notes)
        self.description = self._description(self._recording.metadata)

    def traces(self) -> Iterator[Trace]:
        """Yield every whole trace; what is damaged is left out and named in `faults`."""
        try:
            for number, message in enumerate(self._recording.traces):
                try:
                    yield trace_message.decode(message.data, message.md5sum)
                except TraceRefusedError as error:
                    self.faults.append(Fault(f"{self.name}: recorded trace {number}: {error}"))
        except UnreadableFileError as error:
            self.faults.append(Fault(f"{self.name} cannot be read to its end: {error}"))

    def _description(self, metadata: Optional[str]) -> Optional[Dict[str, Any]]:
        if metadata is None:
            return None
        try:
            return survey_metadata.parse_object(metadata, f"the metadata of {self.name}")
        except SurveyRefusedError as error:
            self.faults.append(Fault(str(error)))
            return None


SurveySource = Union[JsonSource, RecordingSource]


def open_source(path: Path) -> SurveySource:
    """Return the source that a path names.

    Args:
        path: Folder of a survey, folder of its trace files, one trace file, bag or MCAP file.

    Raises:
        AnalysisError: It is none of them.
        OSError: It cannot be read.
    """
    if path.is_dir():
        return _folder_source(path)
    if not path.exists():
        raise AnalysisError(f"{path} does not exist")
    if path.suffix in (recordings.BAG, recordings.MCAP):
        return RecordingSource(path)
    if path.suffix == ".json":
        return JsonSource(path.name, [path], None)
    raise AnalysisError(
        f"{path} is no survey; give its folder, the folder of its JSON files, its .bag or its "
        ".mcap; `gpr20 import` reads other formats"
    )


def _folder_source(folder: Path) -> JsonSource:
    traces = folder / survey_folder.TRACES_FOLDER
    described = folder / survey_folder.SURVEY_FILE
    files = _trace_files(traces if traces.is_dir() else folder)
    description, faults = None, []
    if described.exists():
        try:
            description = survey_metadata.read_description(described)
        except SurveyRefusedError as error:
            faults.append(Fault(str(error)))
    if not files:
        raise AnalysisError(
            f"{folder} holds no survey: neither {survey_folder.TRACES_FOLDER}/ nor the folder "
            "itself has JSON files of traces"
        )
    source = JsonSource(folder.name, files, description)
    source.faults += faults
    return source


def _trace_files(folder: Path) -> List[Path]:
    with os.scandir(str(folder)) as entries:
        names = [entry.name for entry in entries if entry.name.endswith(".json")]
    return [folder / name for name in sorted(names) if name != survey_folder.SURVEY_FILE]


def _decode(content: bytes) -> Trace:
    # Half as long as the standard library's reader takes.
    try:
        values = orjson.loads(content)
    except orjson.JSONDecodeError as error:
        raise TraceRefusedError(f"the file is no strict JSON: {error}") from error
    return trace_json.from_values(values)
