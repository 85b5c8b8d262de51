"""A survey's whole folder as one ZIP file."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ExportFailedError, ImagingError
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.folder_zip import FolderChangedError, add_folder

# The fastest: traces are text of half the size then, and sticks are slow.
LEVEL = 1


def write_zip(folder: Path, target: Any) -> None:
    """Write all files of a survey.

    Args:
        folder: The survey's folder.
        target: A file to write to.

    Raises:
        ExportFailedError: The survey changed meanwhile.
        ImagingError: A file of the survey cannot be read.
        CancelledError: The request was cancelled.
        OSError: The target cannot be written.
    """
    try:
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
            for _ in add_folder(archive, folder):
                pass
    except FolderChangedError as error:
        raise ExportFailedError(
            Message("the survey was changed while it was exported; export it when it has ended"),
            fault=faults.SURVEY_CHANGES,
        ) from error
    except ProcessingError as error:
        raise ImagingError(error.message) from error
