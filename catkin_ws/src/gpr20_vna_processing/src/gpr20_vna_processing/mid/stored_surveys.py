"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import os
import threading
import time
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import TraceRefusedError, storing
from gpr20_survey.folder import survey_folder, trace_files
from gpr20_survey.folder.log_content import LOG
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.recording.mcap_reader import McapTraces
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_block import TraceBlock
from gpr20_vna_processing.mid.survey_summaries import summary_of, trace_names

MAX_SURVEYS_PER_PAGE = 50
MAX_TRACES_PER_READ = 1000
# What is read at once may take 12 MB: 1000 traces of 501 points.
MAX_POINTS = 501_000
# Another client waits meanwhile; a small computer needs 10 s for 1000 JSON files.
MAX_READING_S = 2.0
MOST_SUMMARIES = 1000
# The system marks changes only every few milliseconds, some file systems every two seconds: of
# files that changed less than this ago another change may not show.
SETTLED_NS = 3 * 10**9


class StoredSurvey(NamedTuple):
    """What was to be measured, and what is stored."""

    survey_id: str
    description: Dict[str, Any]
    """survey.json without its report; of its log what was found, and decisions."""
    stored_indices: Tuple[int, ...]


class ReadTraces(NamedTuple):
    """Traces that were read, and why others are unreadable, by their places in the plan."""

    block: TraceBlock
    unreadable: Mapping[int, Message]


class StoredSurveys:
    """Reads the surveys below the data folder, and nothing outside of it; any thread may call it.

    No file is open between two calls: the disk can be removed.
    """

    def __init__(self, data: Path) -> None:
        self._data = data
        self._summaries = lru_cache(MOST_SUMMARIES)(lambda folder, _version: summary_of(folder))
        self._places = lru_cache(1)(lambda folder, _version: _places_in(folder))
        self._one_at_a_time = threading.Lock()

    def list(self, before: str, max_surveys: int) -> Tuple[List[SurveySummary], bool]:
        """Return the newest surveys, before that of a folder if one is named, and if more are left.

        Raises:
            InvalidValueError: That are too many.
            StorageFailedError: The data folder cannot be read.
        """
        number_between("max_surveys", max_surveys, 1, MAX_SURVEYS_PER_PAGE)
        names = sorted((one for one in self._folders() if not before or one < before), reverse=True)
        page = [_known(self._summaries, self._data / one) for one in names[:max_surveys]]
        return page, len(names) > max_surveys

    def survey(self, survey: str) -> StoredSurvey:
        """Return what is known of one survey, by its id or the name of its folder.

        Raises:
            SurveyRefusedError: There is none, or its log cannot be read.
            StorageFailedError: Its folder cannot be read.
        """
        folder, found = find_survey(self._data, survey)
        description = {key: one for key, one in found.description.items() if key != "report"}
        kinds = (Kind.FOUND.value, Kind.DECISION.value)
        log = [one.as_json() for one in found.found.records if one.kind in kinds]
        return StoredSurvey(found.survey_id, {**description, LOG: log}, tuple(trace_names(folder)))

    def traces(self, survey: str, indices: Sequence[int]) -> ReadTraces:
        """Return stored traces that have the frequencies of the first of them.

        Each is read from the MCAP, or from its JSON file if the MCAP has no whole one. The one of
        the first index is in the result; others may be absent from it, to be requested again.

        Raises:
            SurveyRefusedError: There is no such survey, or there are too many indices.
            StorageFailedError: Its folder cannot be read.
        """
        number_between("indices", len(indices), 1, MAX_TRACES_PER_READ)
        folder, found = find_survey(self._data, survey)
        with self._one_at_a_time:
            return self._read(folder, found.survey_id, indices)

    def _read(self, folder: Path, survey_id: str, indices: Sequence[int]) -> ReadTraces:
        traces: List[Trace] = []
        unreadable: Dict[int, Message] = {}
        names, mcap = _known(self._places, folder)
        points, end_s = 0, time.monotonic() + MAX_READING_S
        with mcap.finder() as recorded:
            for index in indices:
                try:
                    trace = recorded(index)
                    if trace is None or trace.survey_id != survey_id:
                        trace = _from_file(folder, survey_id, names.get(index))
                except TraceRefusedError as error:
                    unreadable[index] = error.message
                except OSError as error:
                    unreadable[index] = os_reason(error)
                else:
                    first = traces[0] if traces else trace
                    if np.array_equal(trace.frequency_hz, first.frequency_hz):
                        traces.append(trace)
                        points += len(trace.frequency_hz)
                if points >= MAX_POINTS or time.monotonic() > end_s:
                    break
        return ReadTraces(TraceBlock.of(survey_id, traces), unreadable)

    def _folders(self) -> List[str]:
        failure = Message("the data folder {path} cannot be read", path=printable(self._data))
        with storing(failure, self._data):
            if not self._data.exists():
                return []  # made with the first survey
            folders = [
                one for one in os.scandir(str(self._data)) if one.is_dir(follow_symlinks=False)
            ]
        return [one.name for one in folders if survey_folder.FOLDER_NAME.fullmatch(one.name)]


def _from_file(folder: Path, survey_id: str, name: Optional[str]) -> Trace:
    if name is None:
        raise TraceRefusedError(Message("the storage has no file of this trace"))
    return trace_files.read_trace(folder / survey_folder.TRACES_FOLDER / name, survey_id)


def _places_in(folder: Path) -> Tuple[Mapping[int, str], McapTraces]:
    names = trace_names(folder)
    return names, McapTraces(folder / survey_folder.MCAP_FILE, list(names))


def _known(look: Any, folder: Path) -> Any:
    """Return what a function with a cache returns of a folder: again only after it changed."""
    version = _settled_version(folder)
    return look.__wrapped__(folder, version) if version is None else look(folder, version)


def _settled_version(folder: Path) -> Optional[Tuple[Tuple[int, ...], ...]]:
    """Return what differs if a survey was changed; None if another change might not show."""
    now_ns = time.time_ns()
    version: List[Tuple[int, ...]] = []
    names = (survey_folder.TRACES_FOLDER, survey_folder.LOG_FILE, survey_folder.MCAP_FILE)
    for path in (folder, *(folder / name for name in names)):
        try:
            found = os.lstat(str(path))
        except OSError:
            version.append(())
            continue
        version.append((found.st_mtime_ns, found.st_size, found.st_ino))
        if now_ns - found.st_mtime_ns <= SETTLED_NS:
            return None
    return tuple(version)
