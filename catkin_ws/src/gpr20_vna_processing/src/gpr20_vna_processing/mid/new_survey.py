"""What is checked and made before a survey begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError, printable, storing
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.files import durable_files
from gpr20_survey.files.access import Readers
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.description_recovery import START
from gpr20_survey.trace import utc_time
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.processing_records import BYTES_PER_MB, Storage


def describe(survey_id: str, started_us: int, metadata_json: str, revision: str) -> Dict[str, Any]:
    """Return the content of survey.json of a survey that begins.

    Args:
        survey_id: UUID of the survey.
        started_us: When it started [us since 1970, UTC].
        metadata_json: JSON object.
        revision: Version of the suite.

    Raises:
        SurveyRefusedError: The metadata are not allowed.
    """
    own = {
        "format": survey_metadata.FORMAT,
        "survey_id": survey_id,
        "started": utc_time.iso_text(started_us),
        **START,
        "software_revision": revision,
    }
    return survey_metadata.combine(survey_metadata.parse_metadata(metadata_json), own)


def check_clock(now_ns: int) -> None:
    """Refuse to record while the computer does not know the time.

    Raises:
        SurveyRefusedError: The time [ns since 1970, UTC] cannot be right.
    """
    now_us = now_ns // utc_time.NS_PER_US
    if not utc_time.is_plausible(now_us):
        raise SurveyRefusedError(
            Message(
                "the computer's clock is at {time}; set it, or every time in the recordings would "
                "be wrong",
                time=utc_time.iso_text(now_us),
            ),
            fault=CLOCK_WRONG,
        )


def check_space(storage: Storage, needed_bytes: int, reserve_bytes: int) -> None:
    """Refuse a data folder that is not the right one, and a survey that does not fit on its disk.

    Raises:
        SurveyRefusedError: It is another folder, or the disk has too little space.
        StorageFailedError: The data folder cannot be made, read or written to.
    """
    storage.check_data()
    data = storage.data
    with storing(
        Message("the data folder {path} could not be written to", path=printable(data)), data
    ):
        free = storage.free_bytes(data)
    if needed_bytes + reserve_bytes > free:
        raise SurveyRefusedError(
            Message(
                "the survey needs {needed_mb:.0f} MB and {reserve_mb:.0f} MB must stay free, but "
                "the disk of {path} has only {free_mb:.0f} MB free; make space",
                needed_mb=needed_bytes / BYTES_PER_MB,
                reserve_mb=reserve_bytes / BYTES_PER_MB,
                path=printable(data),
                free_mb=free / BYTES_PER_MB,
            ),
            fault=DISK_FULL,
        )


def make_folder(folder: Path, readers: Readers) -> None:
    """Make the folder of a survey and that of its traces.

    Args:
        folder: The survey's folder.
        readers: Who may read the survey.

    Raises:
        SurveyRefusedError: The folder exists.
        OSError: The disk refused.
    """
    try:
        durable_files.make_new_folder(folder, readers.folder_mode)
    except FileExistsError:
        raise SurveyRefusedError(
            Message(
                "{folder} exists already; every survey needs its own id and folder",
                folder=printable(folder),
            ),
            fault=faults.FOLDER_EXISTS,
        ) from None
    durable_files.make_new_folder(folder / survey_folder.TRACES_FOLDER)
