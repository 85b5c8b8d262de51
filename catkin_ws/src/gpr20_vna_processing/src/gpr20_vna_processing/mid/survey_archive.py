"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.log_content import LOG
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_vna_processing.mid.stored_files import (
    ReadTraces,
    TraceReader,
    settled_version,
    trace_names,
)
from gpr20_vna_processing.mid.survey_summaries import summary_of

MAX_SURVEYS_PER_PAGE = 50
MAX_TRACES_PER_READ = 1000
MOST_KEPT = 1000
"""Summaries."""
SUMMARIZED = (survey_folder.TRACES_FOLDER, survey_folder.LOG_FILE)
"""What changes in a folder with its summary."""


@dataclass(frozen=True)
class StoredSurvey:
    """What was to be measured, and what is stored."""

    survey_id: str
    description: Dict[str, Any]
    """survey.json without its report; of its log what was found, and decisions."""
    stored_indices: Tuple[int, ...]


class SurveyArchive:
    """Reads the surveys below the data folder, and nothing outside of it."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._kept = lru_cache(MOST_KEPT)(lambda folder, _version: summary_of(folder))
        self._reader = TraceReader()

    def list(self, before: str, max_surveys: int) -> Tuple[List[SurveySummary], bool]:
        """Return the newest surveys, and whether older ones are left.

        Args:
            before: Name of a folder; only older surveys are listed. Empty: all.
            max_surveys: How many at most.

        Raises:
            SurveyRefusedError: An argument is not allowed.
            ProcessingError: The data folder cannot be read.
        """
        number_between("max_surveys", max_surveys, 1, MAX_SURVEYS_PER_PAGE)
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
        page = [self._summary(self._data / name) for name in names[:max_surveys]]
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
        description = {key: one for key, one in found.description.items() if key != "report"}
        kinds = (Kind.FOUND.value, Kind.DECISION.value)
        log = [one.as_json() for one in found.found.records if one.kind in kinds]
        return StoredSurvey(found.survey_id, {**description, LOG: log}, tuple(trace_names(folder)))

    def traces(self, survey: str, indices: Sequence[int]) -> ReadTraces:
        """Return stored traces that have the frequencies of the first of them.

        Args:
            survey: Its id, or the name of its folder.
            indices: Their places in the plan. The first one is in the result; others may be
                absent from it, to be requested again.

        Raises:
            SurveyRefusedError: There is no such survey, or there are too many indices.
            ProcessingError: Its folder cannot be read.
        """
        number_between("indices", len(indices), 1, MAX_TRACES_PER_READ)
        folder, found = find_survey(self._data, survey)
        return self._reader.read(folder, found.survey_id, indices)

    def _summary(self, folder: Path) -> SurveySummary:
        """Return the summary of a survey, made again only after its folder changed."""
        version = settled_version(folder, SUMMARIZED, time.time_ns())
        return summary_of(folder) if version is None else self._kept(folder, version)

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
