"""The evidence at the end of a survey: what files it has, and their checksums."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder, survey_metadata

MANIFEST_FILE = "manifest.json"
FORMAT = "gpr20-manifest/1"
DATA_FILES = (survey_folder.SURVEY_FILE, survey_folder.BAG_FILE, survey_folder.MCAP_FILE)


def write_manifest(folder: Path, survey_id: str, revision: str, written: str) -> None:
    """Write the checksums of every file of a survey; return when they are durable.

    What is not data of the survey and cannot be read, such as a link in `damaged/`, is listed
    without a checksum: it must not prevent a survey from being closed.

    Args:
        folder: The survey's folder; nothing in it may change any more.
        survey_id: UUID of the survey.
        revision: Version of the suite.
        written: When, as ISO 8601 text.

    Raises:
        OSError: A file of the survey's data cannot be read, or the disk refused.
    """
    files: Dict[str, Optional[Dict[str, Any]]] = {}
    for name in file_names(folder):
        try:
            sha256, size = file_sums.sha256_and_size(folder / name)
        except OSError:
            if is_data(name):
                raise
            files[name] = None
        else:
            files[name] = {"sha256": sha256, "size": size}
    values = {
        "format": FORMAT,
        "survey_id": survey_id,
        "software_revision": revision,
        "written": written,
        "files": files,
    }
    durable_files.replace_file(folder / MANIFEST_FILE, survey_metadata.encode(values))


def read_sums(folder: Path) -> Dict[str, Any]:
    """Return the checksums in the manifest of a survey; empty if it cannot be read."""
    limit = survey_metadata.MAX_FILE_BYTES
    try:
        with open(open_regular(folder / MANIFEST_FILE), "rb") as stream:
            text = stream.read(limit + 1).decode("ascii")
        files = survey_metadata.parse_object(text, MANIFEST_FILE, limit).get("files")
    except (OSError, UnicodeDecodeError, SurveyRefusedError):
        return {}
    return files if isinstance(files, dict) else {}


def is_unchanged(folder: Path, name: str, sums: Dict[str, Any]) -> bool:
    """Return whether a file is certainly as it was when the manifest was written.

    Args:
        folder: The survey's folder.
        name: The file, relative to the folder.
        sums: The checksums in the manifest.
    """
    try:
        sha256, size = file_sums.sha256_and_size(folder / name)
    except OSError:
        return False
    return bool(sums.get(name) == {"sha256": sha256, "size": size})


def is_data(name: str) -> bool:
    """Return whether a file, named relative to the survey's folder, holds data of the survey."""
    return name in DATA_FILES or name.startswith(f"{survey_folder.TRACES_FOLDER}/")


def file_names(folder: Path) -> Iterator[str]:
    """Yield the names of the files that belong into the manifest of a survey.

    Raises:
        OSError: The folder cannot be read.
    """
    for name in file_sums.regular_files(folder):
        if name != MANIFEST_FILE and not durable_files.is_temporary(Path(name).name):
            yield name
