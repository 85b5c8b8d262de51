"""Check of a survey's files against its manifest, and of the log that goes on behind it."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from pathlib import Path
from typing import List, Optional, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey.errors import ManifestDamagedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.survey_log import FoundLog
from gpr20_survey.results.found import FORMAT, PHOTOS, Found, found_of

NOT_OF_CLOSED = (Kind.PLAN.value, Kind.END.value)


class Seal(enum.Enum):
    """What is known of a survey's manifest."""

    VALID = "valid"
    MISSING = "missing"
    DAMAGED = "damaged"
    REOPENED = "reopened"
    """The survey was reopened, so the manifest does not describe it any more."""


@dataclass
class ManifestCheck:
    """The result of the check."""

    seal: Seal
    manifest: Optional[Manifest] = None
    """The manifest if it is valid or from before a reopening."""
    damage: Optional[Message] = None
    """What is wrong with the manifest itself."""
    differences: List[Message] = field(default_factory=list)
    """Differences between the files and a valid manifest."""


def check_manifest(folder: Path, survey_id: str, log: FoundLog) -> ManifestCheck:
    """Compare a survey's files with its manifest.

    Args:
        folder: The survey's folder.
        survey_id: UUID of the survey.
        log: Its log.

    Raises:
        OSError: The disk cannot be read.
    """
    try:
        sealed = manifest.read_own_manifest(folder, survey_id)
    except FileNotFoundError:
        return ManifestCheck(Seal.MISSING)
    except ManifestDamagedError as error:
        return ManifestCheck(Seal.DAMAGED, damage=error.message)
    if not sealed.is_binding(log.records):
        return ManifestCheck(Seal.REOPENED, sealed)
    differences = [*_differences(folder, sealed), *_other_log(sealed, log)]
    differences += _photo_faults(folder, log.records)
    return ManifestCheck(Seal.VALID, sealed, differences=differences)


def found_in(records: Sequence[LogRecord]) -> List[Found]:
    """Return what the records of a log say was found; those of later versions are left out."""
    values = [one.values for one in records if one.kind == Kind.FOUND]
    return [found_of(one) for one in values if one.get("format") == FORMAT]


def _photo_faults(folder: Path, records: Sequence[LogRecord]) -> List[Message]:
    """Return which photographs are not there, or are not as they were.

    The log vouches for them, and not the manifest: each has the name of its SHA-256. One that no
    record names is left of an interruption.
    """
    try:
        names = {one.photo: one.photo[:64] for one in found_in(records) if one.photo}
    except InvalidValueError as error:
        return [error.message]
    return [
        Message("{file} is missing, or is not the photograph of the log", file=f"{PHOTOS}/{name}")
        for name, own in names.items()
        if getattr(file_sums.sum_if_readable(folder / PHOTOS / name), "sha256", "") != own
    ]


def _differences(folder: Path, sealed: Manifest) -> List[Message]:
    listed, present = sealed.files, set(manifest.file_names(folder))
    found = [
        Message("{file} is in the manifest but does not exist", file=name)
        for name in sorted(listed.keys() - present)
    ]
    found += [
        Message("{file} is not in the manifest", file=name)
        for name in sorted(present - listed.keys())
        if not _is_put_aside(name)
    ]
    # Names from the manifest are only compared; only files found in the folder are opened.
    for name in sorted(present & listed.keys()):
        found += _changes(folder / name, name, sealed)
    return found


def _is_put_aside(name: str) -> bool:
    """Return whether a file is no data: a damaged one, which may be put aside at any time."""
    return name.startswith(f"{survey_folder.DAMAGED_FOLDER}/")


def _other_log(sealed: Manifest, log: FoundLog) -> List[Message]:
    # Only what may be said of a closed survey is an addition.
    found = [
        Message(
            "entry {number} of the log, of kind {kind}, was added after the survey was closed",
            number=one.number,
            kind=one.kind,
        )
        for one in sealed.since(log.records)
        if one.kind in NOT_OF_CLOSED
    ]
    if sealed.covers(log.records) or sealed.log.number in log.lost:
        return found
    return [
        *found,
        Message(
            "the log does not have entry {sealed} as the manifest names it; its last one is entry "
            "{last}",
            sealed=sealed.log.number,
            last=log.records[-1].number if log.records else "-",
        ),
    ]


def _changes(path: Path, name: str, sealed: Manifest) -> List[Message]:
    listed = sealed.files[name]
    if listed is None and _is_put_aside(name):
        return []  # it could not be read at the close
    try:
        # A file of another length differs already, and may take long to read.
        sizes = [] if listed is None else [listed.size]
        present = file_sums.sum_of_sized_file(path, sizes)
    except OSError as error:
        return [Message("{file} cannot be read: {reason}", file=name, reason=os_reason(error))]
    if listed is None:
        return [
            Message(
                "{file} has no SHA-256 in the manifest, because it was unreadable at the close",
                file=name,
            )
        ]
    if present != listed:
        return [
            Message("{file} differs from the manifest: its size or SHA-256 has changed", file=name)
        ]
    return []
