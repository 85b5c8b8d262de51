"""The copy of a survey's description that its MCAP holds since the start, with a checksum."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.mcap_reader import read_attachment


def sealed_description(folder: Path) -> Optional[Dict[str, Any]]:
    """Return the attachment of survey.mcap, which has a checksum.

    It is survey.json as it was when the survey began; what was written later, such as how the
    survey ended, is not in it.

    Returns:
        None if there is no whole copy of this folder's survey.
    """
    path = folder / survey_folder.MCAP_FILE
    try:
        copy = read_attachment(path, survey_folder.SURVEY_FILE)
        if copy is None:
            return None
        text = copy.decode("ascii")
        values = survey_metadata.parse_object(text, path.name, survey_metadata.MAX_FILE_BYTES)
        survey_metadata.check_format(values, path)
    except (OSError, UnicodeDecodeError, SurveyRefusedError):
        return None
    return values if is_of(folder, values["survey_id"]) else None


def is_of(folder: Path, survey_id: str) -> bool:
    """Return whether a survey is that by which a folder is named.

    A folder that was renamed says nothing.
    """
    is_named = survey_folder.FOLDER_NAME.fullmatch(folder.name) is not None
    return not is_named or folder.name.endswith(f"_{survey_id[:8]}")
