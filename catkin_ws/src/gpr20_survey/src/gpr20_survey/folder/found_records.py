"""Records of what was found, in the log of a survey, and their photographs beside it.

A photograph has the name of its SHA-256, and is durable before the record that names it. So the
log vouches for it, and not the manifest: one that no record names is left of an interruption.
"""

from __future__ import annotations

from pathlib import Path
from typing import List, Optional, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.folder.annotating import Fact
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import recover
from gpr20_survey.results.found import FORMAT, PHOTOS, Found, found_of


def add_found(folder: Path, found: Found, photo: Optional[bytes]) -> Fact:
    """Store the photograph of a record, if there is one; return what is added to the log."""
    if photo is not None:
        durable_files.ensure_folder(folder / PHOTOS)
        durable_files.write_new_file(folder / PHOTOS / found.photo, photo)
    return Fact(Kind.FOUND, found.values())


def read_found(folder: Path) -> List[Found]:
    """Return all records of a survey, the first one first."""
    return _found_in(recover(folder).found.records)


def _found_in(records: Sequence[LogRecord]) -> List[Found]:
    """Return what records of a log say was found; those of later versions are left out."""
    values = [one.values for one in records if one.kind == Kind.FOUND]
    return [found_of(one) for one in values if one.get("format") == FORMAT]


def photo_faults(folder: Path, records: Sequence[LogRecord]) -> List[Message]:
    """Return which photographs are not there, or are not as they were."""
    try:
        names = [one.photo for one in _found_in(records) if one.photo]
    except InvalidValueError as error:
        return [error.message]
    return [
        Message("{file} is missing, or is not the photograph of the log", file=f"{PHOTOS}/{name}")
        for name in dict.fromkeys(names)
        if getattr(file_sums.sum_if_readable(folder / PHOTOS / name), "sha256", "") != name[:64]
    ]
