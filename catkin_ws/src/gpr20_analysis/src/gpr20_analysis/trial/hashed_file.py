"""JSON files of a trial, with a SHA-256 of all else in them: no byte changes unseen."""

from __future__ import annotations

import contextlib
import hashlib
import os
from dataclasses import fields
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping

from gpr20_analysis import faults
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder import survey_metadata

OWN = "sha256"
TYPES: Dict[str, Any] = {
    **{"str": str, "bool": bool, "int": int, "float": (int, float)},
    "Optional[float]": (int, float, type(None)),
}
"""What JSON may hold for a field, by its annotation; others are checked where they are read."""


def write_once(path: Path, content: bytes) -> None:
    """Write a file that must not exist yet; return when it is durable.

    Raises:
        ExportError: It exists: nothing of a trial is ever replaced.
        OSError: The disk refused.
    """
    if os.path.lexists(str(path)):
        exists = Message("{path} exists and is never replaced; choose another name", path=path)
        raise ExportError(exists)
    write_new_file(path, content)


def encode(values: Dict[str, Any]) -> bytes:
    """Return the content of a file."""
    own = hashlib.sha256(survey_metadata.encode(values)).hexdigest()
    return survey_metadata.encode({**values, OWN: own})


def check_types(values: Mapping[str, Any], record: type) -> None:
    """Check the plain fields of a dataclass before it is made of values from a file.

    Raises:
        TypeError: One has another type.
        KeyError: One is missing.
    """
    for one in fields(record):
        if one.type in TYPES and not isinstance(values[one.name], TYPES[one.type]):
            raise TypeError(one.name)


@contextlib.contextmanager
def decoded(path: Path, form: str, record: type) -> Iterator[Dict[str, Any]]:
    """Yield what a file holds, also its SHA-256; an entry that is not there or wrong is refused.

    Args:
        path: The file.
        form: Its format.
        record: The dataclass that is made of it.

    Raises:
        UnreadableFileError: It is not equal to the last byte, or its entries are not right.
        OSError: It cannot be read.
    """
    content = read_regular(path)
    try:
        text = content.decode("ascii")
        values = survey_metadata.parse_object(text, path.name, survey_metadata.MAX_FILE_BYTES)
        if encode({key: one for key, one in values.items() if key != OWN}) != content:
            raise ValueError("it has another SHA-256")
        if values.pop("format") != form:
            raise ValueError("it has another format")
        check_types(values, record)
        yield values
    except UnreadableFileError:
        raise
    except (SurveyRefusedError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise UnreadableFileError(
            Message(
                "{file} was changed, or is no {form}", file=path.name, form=form, details=error
            ),
            fault=faults.FILE_CHANGED,
        ) from error
