"""A survey.json that is gone or damaged, from the copy in the survey's MCAP file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.mcap_reader import read_attachment


def description_from_recording(folder: Path) -> Optional[Dict[str, Any]]:
    """Return the description of a survey as it was when its recording began.

    What was written into survey.json later, such as how the survey ended, is not in it.

    Returns:
        None if there is no whole copy, or if something that is no file is in the way of a new one.
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
