"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import itertools
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, SurveyRefusedError, TraceRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_content import UNCONFIRMED
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import read_description, unconfirmed_message
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.folder.survey_search import find_survey
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.coverage import reported_verdict
from gpr20_survey.plan.imported import (
    import_sentence,
    is_imported,
    measured_area,
)
from gpr20_survey.plan.refines import refines_of
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.recent_summaries import RecentSummaries
from gpr20_vna_processing.mid.survey_thumbnail import thumbnail_of

MAX_SURVEYS_PER_PAGE = 50
MAX_TRACES_PER_PAGE = 200
# What a page may hold in memory: 200 traces of 501 points.
MAX_POINTS_PER_PAGE = 100_200

TRACE_FILE = re.compile(r"([0-9]{6})_X[-0-9.]+_Y[-0-9.]+_Z[-+0-9.]+\.json")


@dataclass(frozen=True)
class StoredSurvey:
    """What was to be measured, and what is stored."""

    survey_id: str
    description: Dict[str, Any]
    """survey.json without its report."""
    stored_indices: Tuple[int, ...]


@dataclass(frozen=True)
class TracePage:
    """Some traces of a survey, in the order of the plan."""

    survey_id: str
    traces: Tuple[Trace, ...]
    unreadable: Tuple[Tuple[int, Message], ...]
    """Index and reason of the files that hold no whole trace."""
    next_index: int
    more: bool


class SurveyArchive:
    """Reads the surveys below the data folder, and nothing outside of it."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._summaries = RecentSummaries(self._summary)

    def list(self, before: str, max_surveys: int) -> Tuple[List[SurveySummary], bool]:
        """Return the newest surveys, and whether older ones are left.

        Args:
            before: Name of a folder; only older surveys are listed. Empty: all.
            max_surveys: How many at most.

        Raises:
            SurveyRefusedError: An argument is not allowed.
            ProcessingError: The data folder cannot be read.
        """
        _check_count("max_surveys", max_surveys, MAX_SURVEYS_PER_PAGE)
        if before and not survey_folder.FOLDER_NAME.fullmatch(before):
            raise SurveyRefusedError(
                Message(
                    "before is {before}; it must be empty or the name of a survey's folder, such "
                    "as {example}",
                    before=repr(before[:64]),
                    example=survey_folder.EXAMPLE_FOLDER,
                )
            )
        names = sorted((one for one in self._folders() if not before or one < before), reverse=True)
        page = [self._summaries.of(self._data / name) for name in names[:max_surveys]]
        return page, len(names) > max_surveys

    def survey(self, survey: str) -> StoredSurvey:
        """Return what is known of one survey.

        Args:
            survey: Its id, or the name of its folder.

        Raises:
            SurveyRefusedError: There is none, or its survey.json cannot be read.
            ProcessingError: Its folder cannot be read.
        """
        folder, found = find_survey(self._data, survey)
        description = found.description
        files = _trace_files(folder)
        without_report = {key: value for key, value in description.items() if key != "report"}
        indices = tuple(index for index, _ in files)
        return StoredSurvey(description["survey_id"], without_report, indices)

    def traces(self, survey: str, first_index: int, max_traces: int) -> TracePage:
        """Return the traces from a place in the plan on.

        Args:
            survey: Its id, or the name of its folder.
            first_index: Place in the plan at which to begin.
            max_traces: How many at most.

        Raises:
            SurveyRefusedError: There is no such survey, or an argument is not allowed.
            ProcessingError: Its folder cannot be read.
        """
        _check_count("max_traces", max_traces, MAX_TRACES_PER_PAGE)
        folder, found = find_survey(self._data, survey)
        survey_id = found.survey_id
        due = [one for one in _trace_files(folder) if one[0] >= first_index]
        traces: List[Trace] = []
        unreadable: List[Tuple[int, Message]] = []
        points = 0
        used = 0
        for index, name in itertools.islice(due, max_traces):
            if points >= MAX_POINTS_PER_PAGE:
                break
            used += 1
            path = folder / survey_folder.TRACES_FOLDER / name
            try:
                trace = trace_files.read_trace(path, survey_id)
            except TraceRefusedError as error:
                unreadable.append((index, error.message))
                continue
            except OSError as error:
                unreadable.append((index, os_reason(error)))
                continue
            traces.append(trace)
            points += len(trace.frequency_hz)
        next_index = due[used - 1][0] + 1 if used else first_index
        return TracePage(
            survey_id, tuple(traces), tuple(unreadable), next_index, more=len(due) > used
        )

    def _folders(self) -> Iterator[str]:
        try:
            with os.scandir(str(self._data)) as entries:
                for entry in entries:
                    is_folder = entry.is_dir(follow_symlinks=False)
                    if is_folder and survey_folder.FOLDER_NAME.fullmatch(entry.name):
                        yield entry.name
        except FileNotFoundError:
            return  # made with the first survey
        except OSError as error:
            raise ProcessingError(
                Message(
                    "the data folder {path} cannot be read: {reason}; check the disk",
                    path=printable(self._data),
                    reason=os_reason(error),
                )
            ) from error

    def _summary(self, folder: Path) -> SurveySummary:
        try:
            survey_folder.check_no_links(folder)
            values = read_description(folder)
            survey_folder.check_survey_id(values["survey_id"])
            stored = [index for index, _ in _trace_files(folder)]
            # Without a manifest nothing vouches for the outcome.
            sealed = (folder / MANIFEST_FILE).is_file()
        except ProcessingError as error:
            return SurveySummary(folder.name, problem=error.message)
        area, imported = measured_area(values), is_imported(values)
        planned = 0 if imported else _planned_traces(area)
        outcome = _text(values.get("outcome"))
        # The report of a survey that was cut off may be older than its last traces.
        cut_off = outcome in ("", INTERRUPTED)
        verdict = None if cut_off else reported_verdict(values.get("report"))
        sentence = None if verdict is None else verdict.message
        if imported:
            sentence = import_sentence(values)
        unconfirmed = values.get(UNCONFIRMED)
        if unconfirmed:
            sentence = unconfirmed_message(unconfirmed)
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
            name=_name(values.get(ANNOTATION)),
            thumbnail=thumbnail_of(area, stored),
            fault_code=_text(values.get(survey_metadata.FAULT_CODE)),
        )


def _check_count(name: str, count: int, limit: int) -> None:
    if not 1 <= count <= limit:
        raise SurveyRefusedError(
            Message(
                "{name} is {value}; it must lie between {lower} and {upper}",
                name=name,
                value=count,
                lower=1,
                upper=limit,
            )
        )


def _trace_files(folder: Path) -> List[Tuple[int, str]]:
    """Return index and name of the trace files, ascending; one name per index."""
    found: Dict[int, str] = {}
    try:
        with os.scandir(str(folder / survey_folder.TRACES_FOLDER)) as entries:
            for entry in entries:
                match = TRACE_FILE.fullmatch(entry.name)
                if match and entry.is_file(follow_symlinks=False):
                    found[int(match.group(1))] = entry.name
    except OSError as error:
        raise ProcessingError(
            Message(
                "the traces in {folder} cannot be read: {reason}",
                folder=printable(folder),
                reason=os_reason(error),
            )
        ) from error
    return sorted(found.items())


def _planned_traces(parameters: Any) -> int:
    if not isinstance(parameters, dict):
        return 0
    rotations = parameters.get("polarizations_deg")
    counts = [
        parameters.get("x_points"),
        parameters.get("y_points"),
        len(rotations) if isinstance(rotations, list) else None,
    ]
    planned = 1
    for count in counts:
        if type(count) is not int or not 0 < count <= survey_metadata.MAX_BYTES:
            return 0
        planned *= count
    return min(planned, (1 << 32) - 1)


def _name(annotation: Any) -> str:
    return _text(annotation.get("name")) if isinstance(annotation, dict) else ""


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    # Half of a character, which JSON can hold, cannot be sent: no survey would be listed.
    return value.encode("utf-8", "backslashreplace").decode("utf-8")
