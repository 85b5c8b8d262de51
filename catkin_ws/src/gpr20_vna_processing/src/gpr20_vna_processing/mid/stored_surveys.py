"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import contextlib
import math
import os
import re
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
from gpr20_survey.errors import ProcessingError, TraceRefusedError, storing
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import LOG, UNCONFIRMED, Kind
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import find_survey, read_description, unconfirmed_message
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.recorded_plan import import_sentence, is_imported, measured_area, refines_of
from gpr20_survey.plan.survey_state import reported_verdict
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace, TraceBlock

MOST_CELLS = 24
MOST_PLANNED = 1 << 24
LARGEST_MM = 1e6
TRACE_FILE = re.compile(r"([0-9]{6})_X[-0-9.]+_Y[-0-9.]+_Z[-+0-9.]+\.json")
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


def summary_of(folder: Path) -> SurveySummary:
    """Return the summary of a survey; what is not as it should be is its problem, or left out."""
    try:
        survey_folder.check_no_links(folder)
        values = read_description(folder)
        stored = list(trace_names(folder))
        # Without a manifest nothing vouches for the outcome.
        sealed = (folder / MANIFEST_FILE).is_file()
    except ProcessingError as error:
        return SurveySummary(folder.name, problem=error.message)
    area, imported = measured_area(values), is_imported(values)
    counts = None if imported else _counts_of(area)
    planned = math.prod(counts) if counts else 0
    outcome = _text(values.get("outcome"))
    # The report of a survey that was cut off may be older than its last traces.
    cut_off = outcome in ("", survey_metadata.INTERRUPTED)
    verdict = None if cut_off else reported_verdict(values.get("report"))
    sentence = None if verdict is None else verdict.message
    if imported:
        sentence = import_sentence(values)
    unconfirmed = values.get(UNCONFIRMED)
    if unconfirmed:
        sentence = unconfirmed_message(unconfirmed)
    annotation = values.get(ANNOTATION)
    written: Dict[str, Any] = annotation if isinstance(annotation, dict) else {}
    return SurveySummary(
        folder=folder.name,
        survey_id=values["survey_id"],
        started=_text(values.get("started")),
        outcome=outcome,
        stored_traces=len(stored),
        planned_traces=planned,
        verdict=sentence,
        complete=sealed
        and not unconfirmed
        and outcome == "finished"
        and 0 < planned == len(stored),
        # Data of unknown origin are never shown as those of real ground.
        simulated=values.get("simulated") is not False,
        refines=refines_of(values),
        name=_text(written.get("name")),
        site=_text(written.get("site")),
        operator=_text(written.get("operator")),
        **map_of(area, stored),
    )


def trace_names(folder: Path) -> Dict[int, str]:
    """Return the name of the JSON file of each stored trace by its index, ascending.

    Raises:
        StorageFailedError: The survey's folder cannot be read.
    """
    found: Dict[int, str] = {}
    failure = Message("the traces in {folder} cannot be read", folder=printable(folder))
    with storing(failure, folder):
        for entry in os.scandir(str(folder / survey_folder.TRACES_FOLDER)):
            match = TRACE_FILE.fullmatch(entry.name)
            if match and entry.is_file(follow_symlinks=False):
                found[int(match.group(1))] = entry.name
    return dict(sorted(found.items()))


def map_of(area: Any, stored: Sequence[int]) -> Dict[str, Any]:
    """Return the size of a survey and the map of its stored traces, as fields of its summary."""
    if not isinstance(area, Mapping):
        return {}
    ends: List[Any] = [area.get(f"{one}_{end}_mm") for one in "xy" for end in ("start", "stop")]
    # Compared before it is converted: a whole number of JSON may have hundreds of digits.
    if not all(type(one) in (int, float) and abs(one) <= LARGEST_MM for one in ends):
        return {}
    x_start_mm, x_stop_mm, y_start_mm, y_stop_mm = ends
    size = {"width_mm": abs(x_stop_mm - x_start_mm), "height_mm": abs(y_stop_mm - y_start_mm)}
    counts = _counts_of(area)
    if counts is None:
        return size
    x_points, y_points, turns = counts
    indices = np.asarray([one for one in stored if one < math.prod(counts)], np.int64)
    row, column = np.divmod(indices // turns, x_points)
    # Every second row is measured in the other direction.
    backwards = (row % 2 == 1) != (x_start_mm > x_stop_mm)
    column = np.where(backwards, x_points - 1 - column, column)
    if y_start_mm > y_stop_mm:
        row = y_points - 1 - row
    columns, rows = min(x_points, MOST_CELLS), min(y_points, MOST_CELLS)
    found = np.zeros((rows, columns), np.int64)
    np.add.at(found, (row * rows // y_points, column * columns // x_points), 1)
    planned = np.outer(_share(y_points, rows), _share(x_points, columns)) * turns
    percent = np.clip(found * 100 // planned, (found > 0).astype(np.int64), 100)
    map_percent = percent.astype(np.uint8).tobytes()
    return {**size, "map_columns": columns, "map_rows": rows, "map_percent": map_percent}


def _counts_of(area: Any) -> Optional[Tuple[int, int, int]]:
    """Return how many columns, rows and rotations parameters have; None if they are unreadable."""
    if not isinstance(area, Mapping):
        return None
    rotations = area.get("polarizations_deg")
    turns = len(rotations) if isinstance(rotations, list) else 0
    counts: Any = (area.get("x_points"), area.get("y_points"), turns)
    is_plan = all(type(one) is int and one > 0 for one in counts)
    return counts if is_plan and math.prod(counts) <= MOST_PLANNED else None


def _share(points: int, cells: int) -> np.ndarray:
    """Return how many of the points belong to each cell."""
    return np.bincount(np.arange(points) * cells // points, minlength=cells)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    # Half of a character, which JSON can hold, cannot be sent: no survey would be listed.
    return value.encode("utf-8", "backslashreplace").decode("utf-8")


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
