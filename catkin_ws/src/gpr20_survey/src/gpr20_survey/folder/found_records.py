"""Records of what was found, in the log of a survey, and their photographs beside it.

A photograph has the name of its SHA-256, and is durable before the record that names it. So the
log vouches for it, and not the manifest: one that no record names is left of an interruption.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError, printable
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder.annotating import Change, Fact
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import recover_with_recording
from gpr20_survey.results.found import FORMAT, PHOTO_NAME, PHOTOS, Found, found_of


def add_found(folder: Path, found: Found, photo: Optional[Path]) -> Change:
    """Return the change that adds a record, and its photograph, for `add_to_survey`.

    Args:
        folder: The survey's folder.
        found: The record, without the name of the photograph.
        photo: File of the photograph; None: there is none.

    Raises:
        SurveyRefusedError: The file is no photograph by its ending.
        OSError: The file cannot be read.
    """
    content = b"" if photo is None else read_regular(photo)
    if photo is not None:
        name = hashlib.sha256(content).hexdigest() + photo.suffix.lower()
        if not content or not PHOTO_NAME.fullmatch(name):
            raise SurveyRefusedError(
                Message(
                    "{file} is no photograph; give a file .jpg, .png, .heic or .webp",
                    file=printable(photo),
                )
            )
        found = replace(found, photo=name)

    def change(_description: Dict[str, Any]) -> Fact:
        if photo is not None:
            durable_files.ensure_folder(folder / PHOTOS)
            durable_files.write_new_file(folder / PHOTOS / found.photo, content)
        return Fact(Kind.FOUND, found.values())

    return change


def read_found(folder: Path) -> List[Found]:
    """Return all records of a survey, the first one first.

    Raises:
        SurveyRefusedError: Nothing describes the survey.
        InvalidValueError: A record is not as it should be.
    """
    return found_in(recover_with_recording(folder).found.records)


def found_in(records: Sequence[LogRecord]) -> List[Found]:
    """Return what the records of a log say was found; those of later versions are left out.

    Raises:
        InvalidValueError: One of them is not as it should be.
    """
    values = [one.values or {} for one in records if one.kind == Kind.FOUND.value]
    return [found_of(one) for one in values if one.get("format") == FORMAT]


def photo_faults(folder: Path, records: Sequence[LogRecord]) -> List[Message]:
    """Return which photographs are not there, or are not as they were."""
    try:
        names = [one.photo for one in found_in(records) if one.photo]
    except InvalidValueError as error:
        return [error.message]
    return [
        Message("{file} is missing, or is not the photograph of the log", file=f"{PHOTOS}/{name}")
        for name in dict.fromkeys(names)
        if getattr(file_sums.sum_if_readable(folder / PHOTOS / name), "sha256", "") != name[:64]
    ]
