"""Whether the files of a survey are those of its manifest."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import manifest, survey_folder, survey_metadata

MAX_BYTES = 512 << 20  # a million traces


def check_files(folder: Path, survey_id: str) -> List[str]:
    """Return what differs between a survey's files and its manifest.

    Raises:
        OSError: The disk cannot be read.
    """
    if not (folder / manifest.MANIFEST_FILE).exists():
        return [f"{manifest.MANIFEST_FILE} is missing: nothing tells whether files were changed"]
    try:
        listed = _listed_files(folder / manifest.MANIFEST_FILE, survey_id)
    except (OSError, ValueError) as error:
        return [f"{manifest.MANIFEST_FILE} cannot be read: {error}"]
    present = set(manifest.file_names(folder))
    found = [f"{name} is in the manifest but is gone" for name in sorted(listed.keys() - present)]
    found += [f"{name} is not in the manifest" for name in sorted(present - listed.keys())]
    # Names of the manifest are compared only, never opened.
    for name in sorted(present & listed.keys()):
        found += _differences(folder / name, name, listed[name])
    return found


def _differences(path: Path, name: str, listed: Any) -> List[str]:
    if listed is None and name.startswith(f"{survey_folder.DAMAGED_FOLDER}/"):
        return []  # never data, and it could not be read
    try:
        sha256, size = file_sums.sha256_and_size(path)
    except OSError as error:
        return [f"{name} cannot be read: {error.strerror}"]
    if listed is None:
        return [f"{name} has no SHA-256 in the manifest: it could not be read when it was written"]
    if listed != {"sha256": sha256, "size": size}:
        return [f"{name} is not the file of the manifest: its size or SHA-256 differs"]
    return []


def _listed_files(path: Path, survey_id: str) -> Dict[str, Any]:
    try:
        with open(open_regular(path), "rb") as stream:
            text = stream.read(MAX_BYTES + 1).decode("ascii")
        values = survey_metadata.parse_object(text, path.name, MAX_BYTES)
    except (UnicodeDecodeError, json.JSONDecodeError, SurveyRefusedError) as error:
        raise ValueError(str(error)) from error
    files = values.get("files")
    if values.get("format") != manifest.FORMAT or not isinstance(files, dict):
        raise ValueError(f"it is no manifest of format {manifest.FORMAT}")
    if values.keys() != {"format", "survey_id", "software_revision", "written", "files"}:
        raise ValueError("its entries are not those of a manifest")
    if values["survey_id"] != survey_id:
        raise ValueError(f"it is the manifest of survey {values['survey_id']}")
    return files
