"""Opens what holds a survey: its folder, its JSON files, its bag or its MCAP."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.low import recorded_survey, trace_folder
from gpr20_analysis.low.recorded_survey import RecordedSurvey
from gpr20_analysis.mid.recorded_traces import trace_of
from gpr20_analysis.mid.survey_source import Fault, SurveySource
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.trace.trace import Trace

INDEX_IN_NAME = re.compile(r"(\d{6})_X")


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
    if path.suffix == ".bag":
        return RecordingSource(path, recorded_survey.open_bag(path))
    if path.suffix == ".mcap":
        return RecordingSource(path, recorded_survey.open_mcap(path))
    if path.suffix == ".json":
        return JsonSource(path.name, [path], None)
    raise AnalysisError(
        f"{path} is no survey; give its folder, the folder of its JSON files, its .bag or its "
        ".mcap; `gpr20 import` reads other formats"
    )


class JsonSource:
    """The JSON files of a survey."""

    def __init__(self, name: str, files: List[Path], description: Optional[Dict[str, Any]]) -> None:
        """Take the files; they are read by `traces`."""
        self.name = name
        self.description = description
        self.count = len(files)
        self.faults: List[Fault] = []
        self.notes: List[str] = []
        self._files = files

    def traces(self) -> Iterator[Trace]:
        """Yield every whole trace."""
        for path in self._files:
            try:
                yield trace_folder.read_trace(path)
            except (TraceRefusedError, OSError) as error:
                found = INDEX_IN_NAME.match(path.name)
                index = int(found.group(1)) if found else None
                self.faults.append(Fault(f"{path.name}: {error}", index))


class RecordingSource:
    """A bag or an MCAP file."""

    def __init__(self, path: Path, recording: RecordedSurvey) -> None:
        """Take the open recording."""
        self.name = path.name
        self.count = recording.count
        self.faults: List[Fault] = []
        self.notes: List[str] = list(recording.notes)
        self.description = self._description(recording.metadata)
        self._recording = recording

    def traces(self) -> Iterator[Trace]:
        """Yield every whole trace."""
        try:
            for fields in self._recording.traces:
                try:
                    trace = trace_of(fields)
                except TraceRefusedError as error:
                    self.faults.append(
                        Fault(
                            f"{self.name}: trace {fields.get('index')}: {error}",
                            fields.get("index"),
                        )
                    )
                    continue
                yield trace
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


def _folder_source(folder: Path) -> JsonSource:
    traces = folder / survey_folder.TRACES_FOLDER
    described = folder / survey_folder.SURVEY_FILE
    files = trace_folder.trace_files(traces if traces.is_dir() else folder)
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
