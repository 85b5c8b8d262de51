"""The evidence at the end of a survey: what files it has, their checksums, and how its log ended.

The log judges itself: what is added to it later is an addition, and changes nothing here.
survey.bag, which is made of survey.mcap, is named in the log when it is there.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Dict, Iterator, Mapping, Optional, Sequence

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError
from gpr20_survey.files import durable_files, regular_files
from gpr20_survey.files.regular_files import FileSum, read_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import Kind, LogHead, LogRecord, is_number
from gpr20_survey.plan.markers import PHOTOS

MANIFEST_FILE = "manifest.json"
SIGNATURE_FILE = f"{MANIFEST_FILE}.sig"
FORMAT = "gpr20-manifest/1"
OTHER_FORMAT = re.compile(r"gpr20-manifest/[0-9]+")
MAX_BYTES = 512 << 20  # a million traces
HEAD_BYTES = 1 << 10  # more than there is before the files
CONTENT = "content_sha256"
"""Key of the description: what `content_sum` gives when the survey ends."""
NOT_LISTED = (MANIFEST_FILE, SIGNATURE_FILE, *survey_folder.LOG_FILES, survey_folder.BAG_FILE)


@dataclass(frozen=True)
class Manifest:
    """The checksums of the files of a survey."""

    survey_id: str
    software_revision: str
    """Version of the suite that wrote it."""
    written: str
    """When the survey was closed, as ISO 8601 text."""
    log: LogHead
    """The last record of the log."""
    files: Mapping[str, Optional[FileSum]]
    """Of each file, relative to the folder; None: it was no data and could not be read."""

    def matches(self, name: str, present: Optional[FileSum]) -> bool:
        """Return whether a file has the content that it had when the survey was closed."""
        return present is not None and present == self.files.get(name)

    def covers(self, records: Sequence[LogRecord]) -> bool:
        """Return whether a log has the record with which it ended when this was written."""
        return any(LogHead.of(one) == self.log for one in records)

    def since(self, records: Sequence[LogRecord]) -> Sequence[LogRecord]:
        """Return what was added to the log since this was written."""
        return [one for one in records if one.number > self.log.number]

    def is_binding(self, records: Sequence[LogRecord]) -> bool:
        """Return whether the files must be as they are listed: the survey was not reopened."""
        return all(one.kind != Kind.RESUME.value for one in self.since(records))

    def write_for(self, folder: Path, head: LogRecord) -> None:
        """Write it durably, for the log that ends with this record."""
        content = replace(self, log=LogHead.of(head)).encode()
        durable_files.replace_file(folder / MANIFEST_FILE, content)

    def encode(self) -> bytes:
        """Return the content of manifest.json, which ends with a checksum over all else."""
        values: Dict[str, Any] = {
            "format": FORMAT,
            "survey_id": self.survey_id,
            "software_revision": self.software_revision,
            "written": self.written,
            "log": self.log._asdict(),
            "files": {name: one and one._asdict() for name, one in self.files.items()},
        }
        return survey_metadata.encode({**values, "sha256": _own_sum(values)})


def _own_sum(values: Dict[str, Any]) -> str:
    return hashlib.sha256(survey_metadata.encode(values)).hexdigest()


def decode(content: bytes) -> Manifest:
    """Return the manifest with this content.

    Raises:
        ManifestDamagedError: It is not as it was written.
        SurveyRefusedError: It is of another version.
    """
    text = content.decode("ascii", "replace")
    try:
        values = survey_metadata.parse_object(text, MANIFEST_FILE, MAX_BYTES)
    except SurveyRefusedError as error:
        raise ManifestDamagedError(error.message, fault=faults.MANIFEST_DAMAGED) from error
    own_format, own_sum = values.pop("format", None), values.pop("sha256", None)
    # One of this version in which only that byte changed is damaged.
    is_own = own_format == FORMAT or own_sum == _own_sum({"format": FORMAT, **values})
    if not is_own and OTHER_FORMAT.fullmatch(str(own_format)):
        named = {"file": MANIFEST_FILE, "found": repr(own_format)[:64], "expected": repr(FORMAT)}
        raise SurveyRefusedError(
            Message("the format of {file} is {found}; this software reads {expected}", **named),
            fault=faults.OTHER_VERSION,
        )
    try:
        log, files = LogHead(**values.pop("log")), values.pop("files").items()
        sums = {name: None if one is None else FileSum(**one) for name, one in files}
        manifest = Manifest(**values, log=log, files=sums)
        texts = (manifest.survey_id, manifest.software_revision, manifest.written, log.sha256)
        is_right = is_number(log.number) and all(isinstance(one, str) for one in texts)
        # Equal to the last byte: not even a space can change unseen.
        is_right = is_right and manifest.encode() == content
    except (AttributeError, KeyError, TypeError):
        is_right = False
    if not is_right:
        raise ManifestDamagedError(Message("its own SHA-256 has changed"))
    return manifest


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest in a folder.

    Raises:
        ManifestDamagedError: It is not as it was written, or cannot be read.
        SurveyRefusedError: It is of another version.
        FileNotFoundError: There is none.
    """
    try:
        return decode(read_regular(folder / MANIFEST_FILE, follow_link=False))
    except FileNotFoundError:
        raise
    except OSError as error:
        raise ManifestDamagedError(os_reason(error)) from error


def may_cover(folder: Path, records: Sequence[LogRecord]) -> bool:
    """Return whether the first lines of the manifest name one of these, or there is none."""
    try:
        head = read_regular(folder / MANIFEST_FILE, follow_link=False)[:HEAD_BYTES]
    except OSError:
        return True
    return any(one.sha256.encode() in head for one in reversed(records))


def write_manifest(
    folder: Path,
    survey_id: str,
    head: LogRecord,
    revision: str,
    written: str,
    known: Mapping[str, FileSum] = MappingProxyType({}),
) -> None:
    """Write the checksums of every file of a survey, whose folder may not change any more.

    They are durable when it returns. What is not data of the survey and cannot be read, such as a
    link in `damaged/`, is listed without a checksum: it must not prevent a survey from being
    closed. Files whose content is known, because it was just written, are not read: a change since
    then is found by the next verification.

    Raises:
        OSError: A file of the survey's data cannot be read, or the disk refused.
    """
    names = sorted({*file_names(folder), *known})
    files = {name: known[name] if name in known else _sum_of(folder, name) for name in names}
    Manifest(survey_id, revision, written, LogHead.of(head), files).write_for(folder, head)


def _sum_of(folder: Path, name: str) -> Optional[FileSum]:
    is_data = is_content(name) or name == survey_folder.SURVEY_FILE
    return (regular_files.sum_of_file if is_data else regular_files.sum_if_readable)(folder / name)


def trace_name(file_name: str) -> str:
    """Return the name of a trace's file in a manifest: relative to the survey's folder."""
    return f"{survey_folder.TRACES_FOLDER}/{file_name}"


def file_names(folder: Path) -> Iterator[str]:
    """Yield the names of the files that belong into the manifest of a survey.

    The log names the photographs, each with its checksum.
    """
    for name in regular_files.regular_files(folder):
        if name not in NOT_LISTED and not name.startswith(f"{PHOTOS}/"):
            yield name


def is_content(name: str) -> bool:
    """Return whether a file, named relative to the survey's folder, is a trace or the recording.

    What somebody else put into the folder of the traces is none.
    """
    is_trace = name.startswith(trace_name("")) and name.endswith(".json")
    return is_trace or name == survey_folder.MCAP_FILE


def content_sum(sums: Mapping[str, Optional[FileSum]]) -> str:
    """Return the checksum, as the log names it, of the traces and recording among files."""
    data = sorted((name, one) for name, one in sums.items() if one is not None and is_content(name))
    lines = (f"{one.sha256} {one.size} {name}\n" for name, one in data)
    return hashlib.sha256("".join(lines).encode("utf-8", "surrogateescape")).hexdigest()
