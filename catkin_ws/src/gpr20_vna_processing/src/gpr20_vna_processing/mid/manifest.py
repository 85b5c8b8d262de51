"""The evidence at the end of a survey: what files it has, and their checksums."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator

from gpr20_vna_processing.low import file_sums, json_trace_file
from gpr20_vna_processing.mid import survey_metadata

MANIFEST_FILE = "manifest.json"
FORMAT = "gpr20-manifest/1"


def write_manifest(folder: Path, survey_id: str, revision: str, written: str) -> None:
    """Write the checksums of every file of a survey; return when they are durable.

    Args:
        folder: The survey's folder; nothing in it may change any more.
        survey_id: UUID of the survey.
        revision: Version of the suite.
        written: When, as ISO 8601 text.

    Raises:
        OSError: A file cannot be read, or the disk refused.
    """
    files = {}
    for name in file_names(folder):
        sha256, size = file_sums.sha256_and_size(folder / name)
        files[name] = {"sha256": sha256, "size": size}
    values = {
        "format": FORMAT,
        "survey_id": survey_id,
        "software_revision": revision,
        "written": written,
        "files": files,
    }
    json_trace_file.replace_file(folder / MANIFEST_FILE, survey_metadata.encode(values))


def file_names(folder: Path) -> Iterator[str]:
    """Yield the names of the files that belong into the manifest of a survey.

    Raises:
        OSError: The folder cannot be read.
    """
    for name in file_sums.regular_files(folder):
        if name != MANIFEST_FILE and not json_trace_file.is_temporary(Path(name).name):
            yield name
