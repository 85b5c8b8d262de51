"""Finding a survey in the data folder by its id or its folder's name."""

from __future__ import annotations

from pathlib import Path
from typing import Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.recovery import RecoveredSurvey, recover, recover_with_recording


def find_survey(data: Path, survey: str) -> Tuple[Path, RecoveredSurvey]:
    """Return the folder of a survey, and what it says of its survey.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.

    Raises:
        SurveyRefusedError: There is none, nothing in its folder describes it, or part of it is a
            symbolic link.
        StorageFailedError: A file cannot be read.
    """
    reason = Message(
        "there is no survey {survey} in {folder}",
        survey=repr(survey[:64]),
        folder=printable(data),
    )
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        failure = Message("the survey in {folder} could not be read", folder=printable(folder))
        with storing(failure, folder):
            found = _recovered(folder)
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


def _recovered(folder: Path) -> RecoveredSurvey:
    try:
        return recover(folder)
    except SurveyRefusedError:
        # It takes longer.
        return recover_with_recording(folder)
