"""Finding a survey in the data folder by its id or its folder's name."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, Tuple, TypeVar

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError, printable
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.description_recovery import RecoveredDescription, recover_description

Found = TypeVar("Found")


def find_survey(data: Path, survey: str) -> Tuple[Path, Dict[str, Any]]:
    """Return the folder and the description of a survey, as its survey.json has it.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.

    Raises:
        SurveyRefusedError: There is none, its survey.json cannot be read, or part of it is a
            symbolic link.
    """
    return _find(data, survey, _read_description, lambda values: values)


def find_damaged_survey(data: Path, survey: str) -> Tuple[Path, RecoveredDescription]:
    """Return the folder of a survey, and its description with the help of every copy.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.

    Raises:
        SurveyRefusedError: There is none, its survey.json and the copies cannot be read, or part
            of it is a symbolic link.
    """
    return _find(data, survey, recover_description, lambda found: found.best)


def _find(
    data: Path,
    survey: str,
    read: Callable[[Path], Found],
    description_of: Callable[[Found], Dict[str, Any]],
) -> Tuple[Path, Found]:
    reason = Message(
        "there is no survey {survey} in {folder}",
        survey=repr(survey[:64]),
        folder=printable(data),
    )
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        found = read(folder)
        survey_id = survey_folder.check_survey_id(description_of(found)["survey_id"])
        if survey in (folder.name, survey_id) and folder.name.endswith(f"_{survey_id[:8]}"):
            return folder, found
        reason = Message(
            "{folder} holds survey {found}, not {survey}",
            folder=printable(folder),
            found=survey_id,
            survey=survey[:64],
        )
    raise SurveyRefusedError(reason, fault=faults.UNKNOWN_SURVEY)


def _read_description(folder: Path) -> Dict[str, Any]:
    return survey_metadata.read_description(folder / survey_folder.SURVEY_FILE)
