"""Check of a survey's files against its manifest."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List

from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import manifest, survey_folder, survey_metadata

MAX_BYTES = 512 << 20  # a million traces


def check_files(folder: Path, survey_id: str) -> List[Message]:
    """Return the differences between a survey's files and its manifest.

    Raises:
        OSError: The disk cannot be read.
    """
    if not (folder / manifest.MANIFEST_FILE).exists():
        return [
            Message(
                "{file} is missing, so changes to files cannot be detected",
                file=manifest.MANIFEST_FILE,
            )
        ]
    try:
        listed = _listed_files(folder / manifest.MANIFEST_FILE, survey_id)
    except UnreadableFileError as error:
        return [_unreadable(manifest.MANIFEST_FILE, error.message)]
    except OSError as error:
        return [_unreadable(manifest.MANIFEST_FILE, os_reason(error))]
    present = set(manifest.file_names(folder))
    found = [
        Message("{file} is in the manifest but does not exist", file=name)
        for name in sorted(listed.keys() - present)
    ]
    found += [
        Message("{file} is not in the manifest", file=name)
        for name in sorted(present - listed.keys())
    ]
    # Names from the manifest are only compared; only files found in the folder are opened.
    for name in sorted(present & listed.keys()):
        found += _differences(folder / name, name, listed[name])
    return found


def _differences(path: Path, name: str, listed: Any) -> List[Message]:
    if listed is None and name.startswith(f"{survey_folder.DAMAGED_FOLDER}/"):
        return []  # never data, and it could not be read at the close
    try:
        sha256, size = file_sums.sha256_and_size(path)
    except OSError as error:
        return [_unreadable(name, os_reason(error))]
    if listed is None:
        return [
            Message(
                "{file} has no SHA-256 in the manifest, because it was unreadable at the close",
                file=name,
            )
        ]
    if listed != {"sha256": sha256, "size": size}:
        return [
            Message("{file} differs from the manifest: its size or SHA-256 has changed", file=name)
        ]
    return []


def _unreadable(name: str, reason: Message) -> Message:
    return Message("{file} cannot be read: {reason}", file=name, reason=reason)


def _listed_files(path: Path, survey_id: str) -> Dict[str, Any]:
    try:
        with open(open_regular(path), "rb") as stream:
            text = stream.read(MAX_BYTES + 1).decode("ascii")
        values = survey_metadata.parse_object(text, path.name, MAX_BYTES)
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise UnreadableFileError(Message("it is not valid JSON", details=error)) from error
    except SurveyRefusedError as error:
        raise UnreadableFileError(error.message) from error
    files = values.get("files")
    if values.get("format") != manifest.FORMAT or not isinstance(files, dict):
        raise UnreadableFileError(
            Message("it is not a manifest of format {format}", format=manifest.FORMAT)
        )
    if values.keys() != {"format", "survey_id", "software_revision", "written", "files"}:
        raise UnreadableFileError(Message("its entries are not those of a manifest"))
    if values["survey_id"] != survey_id:
        raise UnreadableFileError(
            Message("it is the manifest of survey {survey}", survey=values["survey_id"])
        )
    return files
