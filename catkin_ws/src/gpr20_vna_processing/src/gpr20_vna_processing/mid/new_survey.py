"""What is checked and made before a survey begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.files.access import Readers
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_log import read_log
from gpr20_survey.folder.survey_metadata import START
from gpr20_survey.trace import utc_time
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.processing_records import BYTES_PER_MB, Storage


def describe(survey_id: str, started_us: int, metadata_json: str, revision: str) -> Dict[str, Any]:
    """Return the description of a survey that begins.

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

    The bags of surveys that have ended, which are being made, take space too.

    Raises:
        SurveyRefusedError: It is another folder, or the disk has too little space.
        StorageFailedError: The data folder cannot be made, read or written to.
    """
    storage.check_data()
    data = storage.data
    with storing(
        Message("the data folder {path} could not be written to", path=printable(data)), data
    ):
        free = storage.free_bytes(data) - storage.bags.outstanding_bytes()
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


def plan_record(description: Dict[str, Any]) -> LogRecord:
    """Return the first record of a survey's log.

    Its time is that of the survey: an opening that is repeated makes the same record.
    """
    return LogRecord.after(None, Kind.PLAN, description, description["started"])


def make_folder(folder: Path, plan: LogRecord, readers: Readers) -> None:
    """Make the folder of a survey, or take one whose survey could not be opened.

    Args:
        folder: The survey's folder.
        plan: The first record of its log.
        readers: Who may read the survey.

    Raises:
        SurveyRefusedError: The folder holds a survey.
        OSError: The disk refused.
    """
    try:
        durable_files.make_new_folder(folder, readers.folder_mode)
    except FileExistsError:
        if not _is_unopened(folder, plan):
            raise _exists(folder) from None


def make_empty(folder: Path, plan: LogRecord) -> None:
    """Remove what an opening that failed has left, and make the folder of the traces.

    Args:
        folder: The survey's folder, locked.
        plan: The first record of its log.

    Raises:
        SurveyRefusedError: The folder holds a survey.
        OSError: The disk refused.
    """
    if not _is_unopened(folder, plan):
        raise _exists(folder)
    durable_files.remove_temporaries(folder)
    for name in _BEGUN:
        durable_files.remove_file(folder / name)
    durable_files.ensure_folder(folder / survey_folder.TRACES_FOLDER)


# In the order in which they are removed: a folder with a log holds a survey.
_BEGUN = (
    *survey_folder.LOG_FILES,
    survey_folder.SURVEY_FILE,
    survey_folder.MCAP_FILE,
)


def _is_unopened(folder: Path, plan: LogRecord) -> bool:
    """Return whether a folder holds nothing but what opening this survey makes.

    The disk may have refused after the log, which comes last, had its name.
    """
    known = {*_BEGUN, survey_folder.TRACES_FOLDER}
    traces = folder / survey_folder.TRACES_FOLDER
    names = {one.name for one in folder.iterdir() if not durable_files.is_temporary(one.name)}
    empty = not traces.exists() or not any(traces.iterdir())
    return names <= known and empty and _holds_only(folder, plan)


def _holds_only(folder: Path, plan: LogRecord) -> bool:
    if not any((folder / name).exists() for name in survey_folder.LOG_FILES):
        return True
    found = read_log(folder)
    # The second file of the log may not be there yet.
    damaged = [folder / name for name in found.damaged if (folder / name).exists()]
    for path in filter(Path.is_file, damaged):
        file_sums.sum_of_file(path)  # a disk that refuses shows nothing; the call may be repeated
    return found.records == (plan,) and not damaged and not found.lost


def _exists(folder: Path) -> SurveyRefusedError:
    return SurveyRefusedError(
        Message(
            "{folder} exists already; every survey needs its own id and folder",
            folder=printable(folder),
        ),
        fault=faults.FOLDER_EXISTS,
    )
