"""Finding a survey in the data folder by its id or its folder's name."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.recovery import RecoveredSurvey, recover


def find_survey(
    data: Path, survey: str, recover_survey: Callable[[Path], RecoveredSurvey] = recover
) -> Tuple[Path, RecoveredSurvey]:
    """Return the folder of a survey, and what it says of its survey.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.
        recover_survey: Reads a folder.

    Raises:
        SurveyRefusedError: There is none, nothing in its folder describes it, or part of it is a
            symbolic link.
    """
    reason = Message(
        "there is no survey {survey} in {folder}",
        survey=repr(survey[:64]),
        folder=printable(data),
    )
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        found = recover_survey(folder)
        survey_id = survey_folder.check_survey_id(found.survey_id)
        if survey in (folder.name, survey_id) and folder.name.endswith(f"_{survey_id[:8]}"):
            return folder, found
        reason = Message(
            "{folder} holds survey {found}, not {survey}",
            folder=printable(folder),
            found=survey_id,
            survey=survey[:64],
        )
    raise SurveyRefusedError(reason, fault=faults.UNKNOWN_SURVEY)
