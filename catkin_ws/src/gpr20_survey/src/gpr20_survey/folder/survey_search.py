"""Finding a survey in the data folder by its id or its folder's name."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError, printable
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.mcap_reader import read_attachment


def find_survey(data: Path, survey: str, recover: bool = False) -> Tuple[Path, Dict[str, Any]]:
    """Return the folder and the description of a survey.

    Args:
        data: The data folder.
        survey: The survey's id, or the name of its folder.
        recover: Whether a description that is damaged is taken from the recording, whose copy has
            a checksum.

    Raises:
        SurveyRefusedError: There is none, its survey.json cannot be read, or part of it is a
            symbolic link.
    """
    reason = Message(
        "there is no survey {survey} in {folder}",
        survey=repr(survey[:64]),
        folder=printable(data),
    )
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        description = _description(folder, recover)
        survey_id = survey_folder.check_survey_id(description["survey_id"])
        if survey in (folder.name, survey_id) and folder.name.endswith(f"_{survey_id[:8]}"):
            return folder, description
        reason = Message(
            "{folder} holds survey {found}, not {survey}",
            folder=printable(folder),
            found=survey_id,
            survey=survey[:64],
        )
    raise SurveyRefusedError(reason)


def recorded_description(folder: Path) -> Optional[Dict[str, Any]]:
    """Return the description of a survey as it was when its MCAP file was begun.

    What was written into survey.json later, such as how the survey ended, is not in it.

    Returns:
        None if there is no whole copy, or if a folder or the like is where the new one would be.
    """
    path = folder / survey_folder.SURVEY_FILE
    if path.exists() and not path.is_file():
        return None
    try:
        copy = read_attachment(folder / survey_folder.MCAP_FILE, survey_folder.SURVEY_FILE)
        if copy is None:
            return None
        text = copy.decode("ascii")
        values = survey_metadata.parse_object(text, "the copy", survey_metadata.MAX_FILE_BYTES)
        survey_metadata.check_format(values, path)
    except (OSError, UnicodeDecodeError, SurveyRefusedError):
        return None
    return values


def _description(folder: Path, recover: bool) -> Dict[str, Any]:
    copy = recorded_description(folder) if recover else None
    try:
        values = survey_metadata.read_description(folder / survey_folder.SURVEY_FILE)
    except SurveyRefusedError:
        if copy is None:
            raise
        return copy
    if copy is None or not folder.name.endswith(f"_{copy['survey_id'][:8]}"):
        return values
    return survey_metadata.with_start_of(values, copy)
