"""Finding a survey in the data folder by its id or its folder's name."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Tuple

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.metadata_recovery import description_from_recording


def find_survey(data: Path, survey: str, restore: bool = False) -> Tuple[Path, Dict[str, Any]]:
    """Return the folder and the description of a survey.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.
        restore: Whether a description that cannot be read is taken from the recording.

    Raises:
        SurveyRefusedError: There is none, its survey.json cannot be read, or part of it is a
            symbolic link.
    """
    reason = f"there is no survey {survey[:64]!r} in {data}"
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        description = _description(folder, restore)
        survey_id = survey_folder.check_survey_id(description["survey_id"])
        if survey in (folder.name, survey_id) and folder.name.endswith(f"_{survey_id[:8]}"):
            return folder, description
        reason = f"{folder} holds survey {survey_id}, not {survey[:64]}"
    raise SurveyRefusedError(reason)


def _description(folder: Path, restore: bool) -> Dict[str, Any]:
    try:
        return survey_metadata.read_description(folder / survey_folder.SURVEY_FILE)
    except SurveyRefusedError:
        restored = description_from_recording(folder) if restore else None
        if restored is None:
            raise
        return restored
