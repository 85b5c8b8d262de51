"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from functools import lru_cache
from pathlib import Path
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import TraceRefusedError, storing
from gpr20_survey.folder import survey_folder, trace_files
from gpr20_survey.folder.log_record import LOG, Kind
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace, TraceBlock
from gpr20_vna_processing.mid.survey_summaries import summary_of, trace_names

MAX_SURVEYS_PER_PAGE = 50
MAX_TRACES_PER_READ = 1000
# What is read at once may take 12 MB: 1000 traces of 501 points.
MAX_POINTS = 501_000
# Another client waits meanwhile.
MAX_READING_S = 2.0
MOST_SUMMARIES = 1000
# The system marks changes only every few milliseconds, some file systems every two seconds: of
# files that changed less than this ago another change may not show.
SETTLED_NS = 3 * 10**9


class StoredSurvey(NamedTuple):
    """What was to be measured, and what is stored."""

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
        self._names = lru_cache(1)(lambda folder, _version: trace_names(folder))
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
        return StoredSurvey({**description, LOG: log}, tuple(trace_names(folder)))

    def traces(self, survey: str, indices: Sequence[int]) -> ReadTraces:
        """Return stored traces that have the frequencies of the first of them.

        Each is read from its JSON file, or from the MCAP if the file is not whole. The one of the
        first index is in the result; others may be absent from it, to be requested again.

        Raises:
            SurveyRefusedError: There is no such survey, or there are too many indices.
            StorageFailedError: Its folder cannot be read.
        """
        number_between("indices", len(indices), 1, MAX_TRACES_PER_READ)
        folder, found = find_survey(self._data, survey)
        with self._one_at_a_time:
            return self._read(folder, found.survey_id, indices)

    def _read(self, folder: Path, survey_id: str, indices: Sequence[int]) -> ReadTraces:
        found: Dict[int, Trace] = {}
        unreadable: Dict[int, Message] = {}
        names = _known(self._names, folder)
        points, end_s = 0, time.monotonic() + MAX_READING_S
        for index in indices:
            try:
                found[index] = _from_file(folder, survey_id, names.get(index))
                points += len(found[index].frequency_hz)
            except TraceRefusedError as error:
                unreadable[index] = error.message
            except OSError as error:
                unreadable[index] = os_reason(error)
            if points >= MAX_POINTS or time.monotonic() > end_s:
                break
        if unreadable:
            found.update(_recorded(folder, survey_id, unreadable.keys()))
        traces = [found[index] for index in indices if index in found]
        same = [one for one in traces if np.array_equal(one.frequency_hz, traces[0].frequency_hz)]
        reasons = {index: one for index, one in unreadable.items() if index not in found}
        return ReadTraces(TraceBlock.of(survey_id, same), reasons)

    def _folders(self) -> List[str]:
        failure = Message("the data folder {path} cannot be read", path=printable(self._data))
        with storing(failure, self._data):
            if not self._data.exists():
                return []  # made with the first survey
            found = os.scandir(str(self._data))
            names = [one.name for one in found if one.is_dir(follow_symlinks=False)]
        return [one for one in names if survey_folder.FOLDER_NAME.fullmatch(one)]


def _from_file(folder: Path, survey_id: str, name: Optional[str]) -> Trace:
    if name is None:
        raise TraceRefusedError(Message("the storage has no file of this trace"))
    return trace_files.read_trace(folder / survey_folder.TRACES_FOLDER / name, survey_id)


def _recorded(folder: Path, survey_id: str, indices: Collection[int]) -> Dict[int, Trace]:
    """Return the traces of these places that the MCAP holds."""
    found = {}
    mcap = StoredMcap(folder / survey_folder.MCAP_FILE)
    with contextlib.suppress(OSError):
        for message in mcap.messages(trace_message.DATATYPE):
            with contextlib.suppress(TraceRefusedError):  # its file says what is wrong
                trace = trace_message.decode(message.data, message.md5sum)
                if trace.survey_id == survey_id and trace.index in indices:
                    found[trace.index] = trace
    return found


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
