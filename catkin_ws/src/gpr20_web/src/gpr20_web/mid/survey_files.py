"""What can be downloaded of a survey: forms by their names in a table, or the whole folder."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import IO, Any, Dict, Iterator, Mapping

from gpr20_common.message import Message
from gpr20_survey.errors import storing
from gpr20_survey.files.file_sums import regular_files
from gpr20_survey.files.folder_lock import writer_of
from gpr20_survey.files.folder_zip import PIECE_BYTES, add_folder
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.signature import SIGNATURE_FILE
from gpr20_web.calls import Body
from gpr20_web.errors import NotFoundError, NotNowError

BYTES = "application/octet-stream"
FILES: Mapping[str, str] = {
    survey_folder.SURVEY_FILE: "application/json",
    survey_folder.LOG_FILE: "application/x-ndjson",
    survey_folder.COPY_FILE: "application/x-ndjson",
    survey_folder.MCAP_FILE: BYTES,
    survey_folder.BAG_FILE: BYTES,
    MANIFEST_FILE: "application/json",
    SIGNATURE_FILE: BYTES,
}
"""Media types of the forms; nothing else of a folder can be named."""
UNREADABLE = Message("the survey could not be read")


class _Collected(bytearray):
    """Takes what a ZIP file writes; without `tell` and `seek` it writes in one pass."""

    def write(self, data: bytes) -> int:
        self += data
        return len(data)

    def flush(self) -> None:
        """Do nothing: everything is here."""


def zip_parts(folder: Path) -> Iterator[bytes]:
    """Yield a ZIP file of a folder as it is made, stored without compression.

    Raises:
        ProcessingError: See `add_folder`; what was yielded so far is no ZIP file.
    """
    parts: Any = _Collected()
    with zipfile.ZipFile(parts, "w", zipfile.ZIP_STORED) as archive:
        for _ in add_folder(archive, folder):
            if len(parts) >= PIECE_BYTES:
                yield bytes(parts)
                parts.clear()
    yield bytes(parts)


def folder_of(data: Path, name: str) -> Path:
    """Return the folder of a survey, in which no file is a link.

    Raises:
        Gpr20Error: There is none, or the name is not that of one.
    """
    if survey_folder.FOLDER_NAME.fullmatch(name):
        for folder in survey_folder.candidate_folders(data, name):
            survey_folder.check_no_links(folder)
            return folder
    raise NotFoundError(Message("there is no survey {survey}", survey=name[:64]))


def check_closed(folder: Path) -> None:
    """Check that nobody writes a survey: half of one looks whole, and its disk has work to do.

    Raises:
        Gpr20Error: Somebody does.
    """
    with storing(UNREADABLE, folder):
        if writer_of(folder) is not None:
            raise NotNowError(
                Message("the survey is being written; it can be downloaded when it has ended")
            )


def sizes_of(folder: Path) -> Dict[str, Any]:
    """Return the forms that a survey has with their sizes, and that of the whole [bytes]."""
    with storing(UNREADABLE, folder):
        sizes = {one: (folder / one).lstat().st_size for one in regular_files(folder)}
    forms = [{"name": one, "bytes": sizes[one]} for one in FILES if one in sizes]
    return {"files": forms, "bytes": sum(sizes.values())}


def form_of(folder: Path, name: str) -> Body:
    """Return one form of a survey.

    Raises:
        Gpr20Error: There is none, or it cannot be read.
    """
    check_closed(folder)
    if name not in FILES or not os.path.lexists(str(folder / name)):
        raise NotFoundError(Message("the survey has no {file}", file=name[:64]))
    with storing(UNREADABLE, folder):
        stream = os.fdopen(open_regular(folder / name), "rb")
    return Body(_pieces(stream, folder), FILES[name], f"{folder.name}_{name}")


def whole_of(folder: Path) -> Body:
    """Return a ZIP file of a survey, which is made while it is sent.

    Raises:
        Gpr20Error: It is being written.
    """
    check_closed(folder)
    return Body(zip_parts(folder), "application/zip", f"{folder.name}_survey.zip")


def _pieces(stream: IO[bytes], folder: Path) -> Iterator[bytes]:
    with storing(UNREADABLE, folder), stream:
        yield from iter(lambda: stream.read(PIECE_BYTES), b"")
