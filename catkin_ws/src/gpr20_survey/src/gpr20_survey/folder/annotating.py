"""Changing what people add to a survey that is not open: annotation and markers."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, Optional

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError, printable, storing
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, sealing, survey_folder, survey_metadata
from gpr20_survey.folder.description_copies import sealed_description
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.plan.annotation import ANNOTATION, Annotation


def annotate_folder(folder: Path, annotation: Annotation) -> None:
    """Change the annotation of a survey that nobody writes; see `change_description`.

    Args:
        folder: The survey's folder.
        annotation: The new annotation, whole.
    """
    change_description(folder, lambda description: {**description, ANNOTATION: annotation.values()})


def change_description(
    folder: Path, change: Callable[[Dict[str, Any]], Optional[Dict[str, Any]]]
) -> Dict[str, Any]:
    """Change survey.json of a survey that nobody writes; return it when that is durable.

    A survey.json that is damaged is not written again: its new checksum would hide the damage.

    Args:
        folder: The survey's folder.
        change: Takes the content of survey.json and returns the whole new one; only
            `survey_metadata.LATER_KEYS` may differ. None: nothing is to be changed.

    Raises:
        SurveyRefusedError: survey.json or the manifest cannot be read, or survey.json is not as
            it was written, or `change` refused.
        StorageFailedError: The disk refused; survey.json has its former content or the new one.
    """
    survey_folder.check_no_links(folder)
    path = folder / survey_folder.SURVEY_FILE
    description = survey_metadata.read_description(path)
    changed = change(description)
    if changed is None:
        return description
    with storing(Message("{path} could not be written", path=printable(path)), path):
        _check_as_written(folder, description)
        sealed = _is_sealed(folder)
        if not sealed:
            durable_files.replace_file(path, survey_metadata.encode(changed))
    if sealed:
        sealing.reseal_description(folder, changed)
    return changed


def _is_sealed(folder: Path) -> bool:
    try:
        return manifest.read_manifest(folder).reopened is None
    except FileNotFoundError:
        return False  # the survey was cut off before its end
    except ManifestDamagedError:
        return True


def _check_as_written(folder: Path, description: Dict[str, Any]) -> None:
    copy = sealed_description(folder)
    changed = [] if copy is None else differences(copy, description)
    if changed:
        raise SurveyRefusedError(
            Message(
                "'{key}' in survey.json in {folder} is {present}, but {former} in its sealed copy "
                "in survey.mcap; nothing was changed; resume the survey, which repairs it",
                key=changed[0].key,
                folder=printable(folder),
                present=changed[0].second,
                former=changed[0].first,
            ),
            fault=faults.DESCRIPTION_DAMAGED,
        )
