"""The surveys of the data folder, read while others may be written; nothing is changed."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_content import LOG, UNCONFIRMED
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.recovery import find_survey, read_description, unconfirmed_message
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.coverage import reported_verdict
from gpr20_survey.plan.imported import (
    import_sentence,
    is_imported,
    measured_area,
)
from gpr20_survey.plan.refines import refines_of
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_vna_processing.mid.recent_summaries import RecentSummaries
from gpr20_vna_processing.mid.survey_thumbnail import thumbnail_of
from gpr20_vna_processing.mid.trace_reader import ReadTraces, TraceReader, trace_names

MAX_SURVEYS_PER_PAGE = 50
MAX_TRACES_PER_READ = 1000


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
        self._summaries = RecentSummaries(self._summary)
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
        _check_count("indices", len(indices), MAX_TRACES_PER_READ)
        folder, found = find_survey(self._data, survey)
        return self._reader.read(folder, found.survey_id, indices)

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
            stored = list(trace_names(folder))
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
            **_people(values.get(ANNOTATION)),
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


def _people(annotation: Any) -> Dict[str, Any]:
    """Return what people wrote that a list is searched for."""
    written = annotation if isinstance(annotation, dict) else {}
    return {name: _text(written.get(name)) for name in ("name", "site", "operator")}


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    # Half of a character, which JSON can hold, cannot be sent: no survey would be listed.
    return value.encode("utf-8", "backslashreplace").decode("utf-8")
