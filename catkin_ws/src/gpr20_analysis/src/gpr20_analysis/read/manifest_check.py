"""Check of a survey's files, and of what its log holds since the close, against its manifest."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator, List, Mapping, Optional, Sequence

from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.message import Message
from gpr20_survey.files.file_sums import FileSum, sum_if_readable, sum_of_file
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.recovery import RecoveredSurvey
from gpr20_survey.folder.survey_log import FoundLog
from gpr20_survey.results.found import FORMAT, PHOTOS, Found, found_of

DATA = "traces and recording"
"""Name of the entry of the log that says that they are others than at the end."""
NOT_OF_CLOSED = (Kind.PLAN.value, Kind.END.value)


@dataclass
class ManifestCheck:
    """The result of the check."""

    manifest: Optional[Manifest] = None
    """None: it is missing or damaged."""
    is_binding: bool = False
    """Whether it describes the survey, which was not reopened since."""
    damage: Optional[Message] = None
    """What is wrong with the manifest itself."""
    differences: List[Message] = field(default_factory=list)
    """Differences between the survey and a binding manifest."""


def check_manifest(folder: Path, recovered: RecoveredSurvey) -> ManifestCheck:
    """Compare a survey's files with its manifest, as it was recovered with the survey.

    Raises:
        OSError: The disk cannot be read.
    """
    sealed, log = recovered.manifest, recovered.found
    if sealed is None:
        return ManifestCheck(damage=recovered.manifest_damage)
    if not sealed.is_binding(log.records):
        return ManifestCheck(sealed)
    differences = [*_differences(folder, sealed), *_other_log(sealed, log)]
    differences += _photo_faults(folder, log.records)
    return ManifestCheck(sealed, is_binding=True, differences=differences)


def has_other_data(description: Mapping[str, Any], sums: Mapping[str, Optional[FileSum]]) -> bool:
    """Return whether these traces and recording are others than when the survey ended."""
    return description.get(manifest.CONTENT) not in (None, manifest.content_sum(sums))


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
        if getattr(sum_if_readable(folder / PHOTOS / name), "sha256", "") != own
    ]


def _differences(folder: Path, sealed: Manifest) -> Iterator[Message]:
    listed, present = sealed.files.keys(), set(manifest.file_names(folder))
    for name in sorted(listed - present):
        yield Message("{file} is in the manifest but does not exist", file=name)
    for name in sorted(present - listed):
        if not _is_put_aside(name):
            yield Message("{file} is not in the manifest", file=name)
    # Names from the manifest are only compared; only files found in the folder are opened.
    for name in sorted(present & listed):
        expected = sealed.files[name]
        if expected is None and _is_put_aside(name):
            continue  # it could not be read at the close
        try:
            if sum_of_file(folder / name) != expected:
                yield Message(
                    "{file} differs from the manifest: its size or SHA-256 has changed", file=name
                )
        except OSError as error:
            yield Message("{file} cannot be read: {reason}", file=name, reason=os_reason(error))


def _is_put_aside(name: str) -> bool:
    """Return whether a file is no data: a damaged one, which may be put aside at any time."""
    return name.startswith(f"{survey_folder.DAMAGED_FOLDER}/")


def _other_log(sealed: Manifest, log: FoundLog) -> Iterator[Message]:
    # Only what may be said of a closed survey is an addition.
    for one in sealed.since(log.records):
        if one.kind in NOT_OF_CLOSED:
            yield Message(
                "entry {number} of the log, of kind {kind}, was added after the survey was closed",
                number=one.number,
                kind=one.kind,
            )
    if not sealed.covers(log.records) and sealed.log.number not in log.lost:
        yield Message(
            "the log does not have entry {sealed} as the manifest names it; its last one is entry "
            "{last}",
            sealed=sealed.log.number,
            last=log.records[-1].number,
        )
