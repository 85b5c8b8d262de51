"""The evidence at the end of a survey: what files it has, and their checksums."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError
from gpr20_survey.files.file_sums import FileSum
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import LogRecord, is_number

MANIFEST_FILE = "manifest.json"
FORMAT = "gpr20-manifest/3"
WITHOUT_LOG_FORMAT = "gpr20-manifest/2"  # lists survey.json instead of the log
FORMER_FORMAT = "gpr20-manifest/1"  # and has no checksum of its own
DATA_FILES = (survey_folder.BAG_FILE, survey_folder.MCAP_FILE)
# The log judges itself, and survey.json is what it says; the last checksum of the log is enough.
JUDGED_BY_LOG = (survey_folder.LOG_FILE, survey_folder.SURVEY_FILE)
MAX_BYTES = 512 << 20  # a million traces

_TEXTS = ("survey_id", "software_revision", "written")
_FORMER_KEYS = {"format", *_TEXTS, "files"}
_KEYS = {*_FORMER_KEYS, "reopened", "rewritten", "log", "next_log", "unconfirmed"}
_KEYS_WITHOUT_LOG = {*_FORMER_KEYS, "reopened", "rewritten", "replacing"}


class LogHead(NamedTuple):
    """The last record of a log."""

    number: int
    sha256: str

    @classmethod
    def of(cls, record: LogRecord) -> LogHead:
        """Return the place and the checksum of a record."""
        return cls(record.number, record.sha256)


@dataclass(frozen=True)
class Manifest:
    """The checksums of the files of a survey."""

    survey_id: str
    software_revision: str
    """Version of the suite that wrote it."""
    written: str
    """When the survey was closed, as ISO 8601 text."""
    files: Mapping[str, Optional[FileSum]]
    """Of each file, relative to the folder; None: it was no data and could not be read."""
    log: Optional[LogHead] = None
    """The last record of the log; None: the survey is one of an earlier version."""
    next_log: Optional[LogHead] = None
    """The record that is being added to the log; None again when that is done."""
    unconfirmed: Tuple[str, ...] = ()
    """Names of the entries of survey.json that nothing vouches for."""
    replacing: Mapping[str, FileSum] = field(default_factory=dict)
    """Of an earlier version: the new content of a file that was being replaced."""
    reopened: Optional[str] = None
    """When the survey was reopened: its files may have changed since. None: it was not."""
    rewritten: Tuple[Mapping[str, str], ...] = ()
    """`time` and `reason` of each time that a lost or damaged manifest was written again."""
    covers_itself: bool = True
    """Whether a change of any byte of the manifest itself is found."""

    def matches(self, name: str, present: Optional[FileSum]) -> bool:
        """Return whether a file has the content that it had when the survey was closed."""
        return present is not None and present in (self.files.get(name), self.replacing.get(name))

    def covers(self, records: Sequence[LogRecord]) -> bool:
        """Return whether a log ends as it did when this was written."""
        head = LogHead.of(records[-1]) if records else None
        return head is not None and head in (self.log, self.next_log)

    def encode(self) -> bytes:
        """Return the content of manifest.json, which ends with a checksum over all else."""
        values = {
            "format": FORMAT,
            "survey_id": self.survey_id,
            "software_revision": self.software_revision,
            "written": self.written,
            "reopened": self.reopened,
            "rewritten": [dict(one) for one in self.rewritten],
            "log": self.log and self.log._asdict(),
            "next_log": self.next_log and self.next_log._asdict(),
            "unconfirmed": list(self.unconfirmed),
            "files": {name: one and one._asdict() for name, one in self.files.items()},
        }
        return survey_metadata.encode({**values, "sha256": _own_sum(values)})


def decode(content: bytes) -> Manifest:
    """Return the manifest with this content.

    Raises:
        ManifestDamagedError: It is not as it was written.
    """
    try:
        text = content.decode("ascii")
        values = survey_metadata.parse_object(text, MANIFEST_FILE, MAX_BYTES)
    except UnicodeDecodeError as error:
        raise ManifestDamagedError(Message("it is not ASCII text", details=error)) from error
    except SurveyRefusedError as error:
        raise ManifestDamagedError(error.message, fault=faults.MANIFEST_DAMAGED) from error
    if values.get("format") in (FORMAT, WITHOUT_LOG_FORMAT):
        return _decoded(content, values)
    if values.get("format") == FORMER_FORMAT:
        return _former(values)
    raise ManifestDamagedError(
        Message("it is not a manifest of format {format}", format=FORMAT),
    )


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest of a survey.

    Raises:
        ManifestDamagedError: It is not as it was written.
        FileNotFoundError: There is none.
        OSError: It cannot be read.
    """
    with open(open_regular(folder / MANIFEST_FILE), "rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > MAX_BYTES:
            raise ManifestDamagedError(Message("it has {size} bytes", size=size))
        return decode(stream.read())


def read_own_manifest(folder: Path, survey_id: str) -> Manifest:
    """Return the manifest of a survey, if it is whole and that survey's.

    Args:
        folder: The survey's folder.
        survey_id: UUID of the survey.

    Raises:
        ManifestDamagedError: It is not as it was written, cannot be read, or is another survey's.
        FileNotFoundError: There is none.
    """
    try:
        found = read_manifest(folder)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise ManifestDamagedError(os_reason(error)) from error
    if found.survey_id != survey_id:
        raise ManifestDamagedError(
            Message("it is the manifest of survey {survey}", survey=found.survey_id)
        )
    return found


def trace_name(file_name: str) -> str:
    """Return the name of a trace's file in a manifest: relative to the survey's folder."""
    return f"{survey_folder.TRACES_FOLDER}/{file_name}"


def is_data(name: str) -> bool:
    """Return whether a file, named relative to the survey's folder, holds data of the survey."""
    return name in (*DATA_FILES, survey_folder.SURVEY_FILE) or name.startswith(trace_name(""))


def _own_sum(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(survey_metadata.encode(dict(values))).hexdigest()


def _decoded(content: bytes, values: Dict[str, Any]) -> Manifest:
    own_sum = values.pop("sha256", None)
    # Equal to the last byte: not even a space can change unseen.
    if own_sum != _own_sum(values) or survey_metadata.encode({**values, "sha256": own_sum}) != (
        content
    ):
        raise ManifestDamagedError(Message("its own SHA-256 has changed"))
    has_log = values["format"] == FORMAT
    rewritten = values.get("rewritten")
    if (
        values.keys() != (_KEYS if has_log else _KEYS_WITHOUT_LOG)
        or not isinstance(values.get("replacing", {}), dict)
        or not isinstance(values.get("unconfirmed", []), list)
        or not isinstance(rewritten, list)
        or not all(isinstance(one, dict) for one in rewritten)
    ):
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    return _manifest(
        values,
        log=_head(values.get("log")),
        next_log=_head(values.get("next_log")),
        unconfirmed=tuple(map(str, values.get("unconfirmed", []))),
        replacing={name: _sum(one) for name, one in values.get("replacing", {}).items()},
        reopened=values["reopened"],
        rewritten=tuple(rewritten),
    )


def _head(values: Any) -> Optional[LogHead]:
    if values is None:
        return None
    if not isinstance(values, dict) or values.keys() != set(LogHead._fields):
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    if not is_number(values["number"]) or not isinstance(values["sha256"], str):
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    return LogHead(**values)


def _former(values: Dict[str, Any]) -> Manifest:
    if values.keys() != _FORMER_KEYS:
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    return _manifest(values, covers_itself=False)


def _manifest(values: Dict[str, Any], **more: Any) -> Manifest:
    files = values["files"]
    if not isinstance(files, dict) or not all(isinstance(values[key], str) for key in _TEXTS):
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    sums = {name: None if one is None else _sum(one) for name, one in files.items()}
    return Manifest(**{key: values[key] for key in _TEXTS}, files=sums, **more)


def _sum(values: Any) -> FileSum:
    if not isinstance(values, dict) or values.keys() != {"sha256", "size"}:
        raise ManifestDamagedError(Message("its entries are not those of a manifest"))
    return FileSum(**values)
