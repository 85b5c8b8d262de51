"""Writing the manifest of a survey, and adding to a survey that is closed."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Dict, Iterator, Mapping, Optional, Tuple

from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.files.file_sums import FileSum
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_content import UNCONFIRMED
from gpr20_survey.folder.log_record import LogRecord
from gpr20_survey.folder.manifest import MANIFEST_FILE, LogHead, Manifest
from gpr20_survey.folder.signature import SIGNATURE_FILE
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.results.found import PHOTOS

CONTENT = "content_sha256"
"""Key of survey.json: what `content_sum` gives when the survey ends."""
DATA = "traces and recordings"
"""Name of the entry of survey.json that says that they are others than at the end."""
NO_SUMS: Mapping[str, FileSum] = MappingProxyType({})
# The manifest and its signature cannot be listed in the manifest itself.
NOT_LISTED = (MANIFEST_FILE, SIGNATURE_FILE, *manifest.JUDGED_BY_LOG)


def write_manifest(
    folder: Path,
    log: SurveyLog,
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
        log: The survey's log.
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
    description = log.description
    new = Manifest(
        description["survey_id"],
        revision,
        written,
        files,
        LogHead.of(log.last),
        unconfirmed=_names(description),
        rewritten=rewritten,
    )
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


def seal_log(folder: Path, sealed: Manifest, log: SurveyLog, is_adding: bool = False) -> Manifest:
    """Let the manifest of a closed survey name the present log; return it when it is durable.

    Damaged forms of the log that were put aside are listed too. The manifest of an earlier
    version, which lists survey.json, becomes one of this version.

    Args:
        folder: The survey's folder.
        sealed: Its manifest.
        log: Its log.
        is_adding: Whether survey.json may lack the last record until the manifest is written again.

    Raises:
        OSError: The disk refused.
    """
    head = LogHead.of(log.last)
    files = {name: one for name, one in sealed.files.items() if name not in manifest.JUDGED_BY_LOG}
    aside = f"{survey_folder.DAMAGED_FOLDER}/"
    for name in file_names(folder):
        if name.startswith(aside) and name not in files:
            files[name] = _sum(folder, name)
    present = replace(
        sealed,
        files=files,
        log=head,
        next_log=head if is_adding else None,
        unconfirmed=_names(log.description),
        replacing={},
        covers_itself=True,
    )
    durable_files.replace_file(folder / MANIFEST_FILE, present.encode())
    return present


def name_log(folder: Path, sealed: Manifest, log: SurveyLog) -> None:
    """Let the manifest name a log of which survey.json may lack the last record; see `seal_log`."""
    seal_log(folder, sealed, log, is_adding=True)


def write_sealed(folder: Path, sealed: Manifest, log: SurveyLog) -> Manifest:
    """Write both files of the log of a closed survey again, and return its new manifest.

    After a power cut at any moment the manifest vouches for the log as it is then.

    Args:
        folder: The survey's folder.
        sealed: Its manifest.
        log: Its log; it may have more records than the manifest names.

    Raises:
        OSError: The disk refused; the call may be repeated.
    """
    if sealed.log is None:
        # It lists survey.json, which must not change before it names the log.
        log.write(lambda: name_log(folder, sealed, log))
    else:
        both = replace(sealed, next_log=LogHead.of(log.last))
        durable_files.replace_file(folder / MANIFEST_FILE, both.encode())
        log.write()
    return seal_log(folder, sealed, log)


def add_sealed(folder: Path, sealed: Manifest, log: SurveyLog, record: LogRecord) -> None:
    """Add a record to the log of a closed survey, and to what its manifest names.

    After a power cut at any moment the log ends with this record or with the one before it, and
    the manifest names both until the record is durable.

    Args:
        folder: The survey's folder.
        sealed: Its manifest, which names the present log.
        log: The survey's log.
        record: The next record.

    Raises:
        OSError: The disk refused; the call may be repeated.
    """
    # Its last seal may have failed, so that it names this log as the next one.
    both = replace(sealed, log=LogHead.of(log.last), next_log=LogHead.of(record))
    durable_files.replace_file(folder / MANIFEST_FILE, both.encode())
    log.add(record)
    seal_log(folder, both, log)


def file_names(folder: Path) -> Iterator[str]:
    """Yield the names of the files that belong into the manifest of a survey.

    The log names the photographs, each with its checksum.

    Raises:
        OSError: The folder cannot be read.
    """
    for name in file_sums.regular_files(folder):
        if name.startswith(f"{PHOTOS}/"):
            continue
        if name not in NOT_LISTED and not durable_files.is_temporary(Path(name).name):
            yield name


def data_sums(folder: Path) -> Dict[str, FileSum]:
    """Return the checksums of the traces and the recordings of a survey.

    Raises:
        OSError: One of them cannot be read.
    """
    names = filter(_is_content, file_names(folder))
    return {name: file_sums.sum_of_file(folder / name) for name in names}


def has_other_data(
    description: Mapping[str, Any], sums: Mapping[str, Optional[FileSum]]
) -> Optional[bool]:
    """Return whether traces or recordings are others than when the survey ended.

    Args:
        description: Content of survey.json.
        sums: Of each file of the survey, by its name relative to the folder.

    Returns:
        None if survey.json does not say what they were.
    """
    if description.get(CONTENT) is None:
        return None
    data = {name: one for name, one in sums.items() if one is not None and _is_content(name)}
    return bool(content_sum(data) != description[CONTENT])


def content_sum(sums: Mapping[str, FileSum]) -> str:
    """Return a checksum of the traces and the recordings of a survey, as its log names it.

    Args:
        sums: Of each of these files, by its name relative to the folder.
    """
    lines = (f"{sums[name].sha256} {sums[name].size} {name}\n" for name in sorted(sums))
    return hashlib.sha256("".join(lines).encode("utf-8", "surrogateescape")).hexdigest()


def _is_content(name: str) -> bool:
    # What somebody else put into the folder of the traces is none.
    is_trace = name.startswith(manifest.trace_name("")) and name.endswith(".json")
    return is_trace or name in manifest.DATA_FILES


def _names(description: Mapping[str, Any]) -> Tuple[str, ...]:
    return tuple(description.get(UNCONFIRMED, {}))


def _sum(folder: Path, name: str) -> Optional[FileSum]:
    try:
        return file_sums.sum_of_file(folder / name)
    except OSError:
        if manifest.is_data(name):
            raise
        return None
