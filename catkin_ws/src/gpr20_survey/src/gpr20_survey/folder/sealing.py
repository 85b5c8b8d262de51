"""Writing the manifest of a survey, and changing what it covers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Dict, Iterator, Mapping, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import (
    ManifestDamagedError,
    SurveyRefusedError,
    printable,
    storing,
)
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.files.file_sums import FileSum
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.folder.manifest import MANIFEST_FILE, Manifest
from gpr20_survey.folder.signature import SIGNATURE_FILE

NO_SUMS: Mapping[str, FileSum] = MappingProxyType({})


def write_manifest(
    folder: Path,
    survey_id: str,
    revision: str,
    written: str,
    known: Mapping[str, FileSum] = NO_SUMS,
    rewritten: Tuple[Mapping[str, str], ...] = (),
) -> None:
    """Write the checksums of every file of a survey; return when they are durable.

    What is not data of the survey and cannot be read, such as a link in `damaged/`, is listed
    without a checksum: it must not prevent a survey from being closed.

    Args:
        folder: The survey's folder; nothing in it may change any more.
        survey_id: UUID of the survey.
        revision: Version of the suite.
        written: When, as ISO 8601 text.
        known: Files whose content is known because it was just written; they are not read. A
            change since then is found by the next verification.
        rewritten: `time` and `reason` of each time that a lost manifest was written again.

    Raises:
        OSError: A file of the survey's data cannot be read, or the disk refused.
    """
    files: Dict[str, Optional[FileSum]] = {}
    for name in sorted({*file_names(folder), *known}):
        files[name] = known[name] if name in known else _sum(folder, name)
    new = Manifest(survey_id, revision, written, files, rewritten=rewritten)
    durable_files.replace_file(folder / MANIFEST_FILE, new.encode())


def mark_reopened(folder: Path, sealed: Manifest, now: str) -> None:
    """Note in the manifest of a survey that its files are about to change.

    Args:
        folder: The survey's folder.
        sealed: Its manifest.
        now: The present moment, as ISO 8601 text.

    Raises:
        OSError: The disk refused.
    """
    marked = replace(sealed, reopened=now)
    durable_files.replace_file(folder / MANIFEST_FILE, marked.encode())


def reseal_description(folder: Path, new_values: Dict[str, Any]) -> None:
    """Replace survey.json of a closed survey, and its checksum in the manifest.

    After a power cut at any moment survey.json has the former or the new content, and the
    manifest covers both until the replacement is finished.

    Args:
        folder: The survey's folder.
        new_values: The whole new content. Only `survey_metadata.LATER_KEYS` may differ.

    Raises:
        SurveyRefusedError: The survey is not closed, survey.json or the manifest is damaged, or
            the new content changes what must not change.
        StorageFailedError: The disk refused; the call may be repeated.
    """
    path = folder / survey_folder.SURVEY_FILE
    with storing(Message("{path} could not be replaced", path=printable(path)), path):
        sealed = _seal_of(folder)
        present = file_sums.sum_of_file(path)
        if not sealed.matches(path.name, present):
            raise SurveyRefusedError(
                Message(
                    "{path} differs from the manifest, so it is damaged; resume the survey, which "
                    "repairs it, or restore the file",
                    path=printable(path),
                ),
                fault=faults.DESCRIPTION_DAMAGED,
            )
        changed = differences(survey_metadata.read_description(path), new_values)
        if changed:
            raise SurveyRefusedError(
                Message("'{key}' of survey.json cannot be changed", key=changed[0].key)
            )
        content = survey_metadata.encode(new_values)
        new = file_sums.sum_of(content)
        both = replace(
            sealed, files={**sealed.files, path.name: present}, replacing={path.name: new}
        )
        durable_files.replace_file(folder / MANIFEST_FILE, both.encode())
        durable_files.replace_file(path, content)
        done = replace(sealed, files={**sealed.files, path.name: new}, replacing={})
        durable_files.replace_file(folder / MANIFEST_FILE, done.encode())


def file_names(folder: Path) -> Iterator[str]:
    """Yield the names of the files that belong into the manifest of a survey.

    Raises:
        OSError: The folder cannot be read.
    """
    # The manifest and its signature cannot be listed in the manifest itself.
    others = (MANIFEST_FILE, SIGNATURE_FILE)
    for name in file_sums.regular_files(folder):
        if name not in others and not durable_files.is_temporary(Path(name).name):
            yield name


def _sum(folder: Path, name: str) -> Optional[FileSum]:
    try:
        return file_sums.sum_of_file(folder / name)
    except OSError:
        if manifest.is_data(name):
            raise
        return None


def _seal_of(folder: Path) -> Manifest:
    try:
        sealed = manifest.read_manifest(folder)
    except FileNotFoundError:
        raise SurveyRefusedError(
            Message(
                "the survey in {folder} is not closed: it has no manifest; stop or resume it",
                folder=printable(folder),
            ),
            fault=faults.NOT_CLOSED,
        ) from None
    except ManifestDamagedError as error:
        raise SurveyRefusedError(
            Message(
                "{path} is damaged: {reason}; gpr20 repair writes it again if all else is right",
                path=printable(folder / MANIFEST_FILE),
                reason=error.message,
            ),
            fault=faults.MANIFEST_DAMAGED,
        ) from error
    if sealed.reopened is not None:
        raise SurveyRefusedError(
            Message(
                "the survey in {folder} is not closed: it was reopened; resume and stop it",
                folder=printable(folder),
            ),
            fault=faults.NOT_CLOSED,
        )
    return sealed
