"""A survey that was closed before this process began."""

from __future__ import annotations

from pathlib import Path
from typing import Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest
from gpr20_survey.folder.survey_search import find_survey
from gpr20_vna_processing.mid.processing_records import ClosedSurvey


def find_ended_survey(data: Path, survey_id: str, outcome: str) -> Optional[ClosedSurvey]:
    """Return a survey whose folder says that it ended in this way; None if there is none.

    Args:
        data: The data folder.
        survey_id: UUID.
        outcome: As it was given when the survey was closed.
    """
    try:
        folder, description = find_survey(data, survey_id)
    except SurveyRefusedError:
        return None
    stored = description.get("stored_traces")
    # The manifest comes last: without it the survey was cut off while it was closed.
    if not (folder / manifest.MANIFEST_FILE).is_file() or description.get("outcome") != outcome:
        return None
    return ClosedSurvey(survey_id, folder, stored) if isinstance(stored, int) else None
