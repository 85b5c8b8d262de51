"""Changing the annotation of a survey that is not open."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Dict

from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError, printable, storing
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.survey_search import recorded_description
from gpr20_survey.plan.annotation import ANNOTATION, Annotation


def annotate_folder(folder: Path, annotation: Annotation) -> Dict[str, Any]:
    """Change the annotation of a survey that nobody writes; return when that is durable.

    A survey.json that is damaged is not written again: its new checksum would hide the damage.

    Args:
        folder: The survey's folder.
        annotation: The new annotation, whole.

    Returns:
        The new content of survey.json.

    Raises:
        SurveyRefusedError: survey.json cannot be read, or is not as it was written.
        StorageFailedError: The disk refused; the survey has its former annotation.
    """
    survey_folder.check_no_links(folder)
    path = folder / survey_folder.SURVEY_FILE
    description = survey_metadata.read_description(path)
    with storing(Message("{path} could not be written", path=printable(path)), path):
        _check_as_written(folder, description)
        changed = {**description, ANNOTATION: annotation.values()}
        _replace(folder, changed)
    return changed


def _replace(folder: Path, changed: Dict[str, Any]) -> None:
    content = survey_metadata.encode(changed)
    if not (folder / manifest.MANIFEST_FILE).exists():
        durable_files.replace_file(folder / survey_folder.SURVEY_FILE, content)
        return
    if not manifest.is_unchanged(folder, survey_folder.SURVEY_FILE, manifest.read_sums(folder)):
        raise SurveyRefusedError(
            Message("survey.json in {folder} differs from its manifest", folder=printable(folder))
        )
    sealed = json.loads((folder / manifest.MANIFEST_FILE).read_text("ascii"))
    durable_files.replace_file(folder / survey_folder.SURVEY_FILE, content)
    sealed["files"][survey_folder.SURVEY_FILE] = {
        "sha256": hashlib.sha256(content).hexdigest(),
        "size": len(content),
    }
    durable_files.replace_file(folder / manifest.MANIFEST_FILE, survey_metadata.encode(sealed))


def _check_as_written(folder: Path, description: Dict[str, Any]) -> None:
    copy = recorded_description(folder)
    if copy is not None and _constant(copy) != _constant(description):
        raise SurveyRefusedError(
            Message(
                "survey.json in {folder} differs from its sealed copy in survey.mcap; nothing was "
                "changed; check the survey with gpr20 verify",
                folder=printable(folder),
            )
        )


def _constant(description: Dict[str, Any]) -> Dict[str, Any]:
    later = survey_metadata.LATER_KEYS
    return {key: value for key, value in description.items() if key not in later}
