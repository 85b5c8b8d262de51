"""What is checked and made before a survey begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.faults import CLOCK_WRONG, NO_PLAN
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import is_temporary, read_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.log_record import LOG, UNCONFIRMED, LogRecord
from gpr20_survey.folder.manifest import CONTENT
from gpr20_survey.folder.survey_metadata import FORMAT, START, parse_object
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.trace import utc_time
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB
from gpr20_vna_processing.mid.processing_records import Storage

# In the order in which they are removed: a folder with a log holds a survey.
BEGUN = (*survey_folder.LOG_FILES, survey_folder.SURVEY_FILE, survey_folder.MCAP_FILE)
# What comes into a description after the start, and the records of the log themselves.
LOGGED_KEYS = ("resumed", "report", MARKERS, LOG, UNCONFIRMED, CONTENT)
OWN_KEYS = {"format", "survey_id", "started", "software_revision", *START, *LOGGED_KEYS}


def describe(survey_id: str, started_us: int, metadata_json: str, revision: str) -> Dict[str, Any]:
    """Return the description of a survey that begins [us since 1970, UTC].

    Raises:
        SurveyRefusedError: The metadata are not allowed.
    """
    own = {
        "format": FORMAT,
        "survey_id": survey_id,
        "started": utc_time.iso_text(started_us),
        **START,
        "software_revision": revision,
    }
    metadata = parse_object(metadata_json, "metadata_json")
    try:
        annotation_of(metadata)
    except InvalidValueError as error:
        raise SurveyRefusedError(
            Message("the annotation in metadata_json is refused: {reason}", reason=error.message)
        ) from error
    for key, value in metadata.items():
        if key in LOGGED_KEYS or own.get(key, value) != value:
            raise SurveyRefusedError(
                Message(
                    "metadata_json holds '{key}', which the storage writes itself; leave it out",
                    key=key,
                    details=repr(str(value)[:64]),
                )
            )
    return {**own, **metadata}


def metadata_of(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return the part of the description of a survey that was given when it began."""
    return {key: value for key, value in description.items() if key not in OWN_KEYS}


def checked_time(now_ns: int) -> int:
    """Return the time [ns since 1970, UTC], if the computer knows it.

    Raises:
        SurveyRefusedError: It cannot be right.
    """
    now_us = now_ns // utc_time.NS_PER_US
    if not utc_time.is_plausible(now_us):
        raise SurveyRefusedError(
            Message(
                "the computer's clock is at {time}; set it, or every time in the recordings would "
                "be wrong",
                time=utc_time.moment_text(utc_time.iso_text(now_us)),
            ),
            fault=CLOCK_WRONG,
        )
    return now_ns


def check_space(storage: Storage, needed_bytes: int) -> None:
    """Refuse a survey that does not fit on the disk, beside the bags that are not made yet.

    Raises:
        SurveyRefusedError: The disk has too little space.
        StorageFailedError: The data folder cannot be read.
    """
    data, reserve_bytes = storage.data, storage.parameters.disk_reserve_bytes
    failure = Message("the data folder {path} could not be written to", path=printable(data))
    with storing(failure, data):
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


def empty_folder(folder: Path, plan: LogRecord) -> None:
    """Remove what an opening of the same survey that failed has left; make the traces' folder.

    Raises:
        SurveyRefusedError: The folder holds anything else.
        OSError: The disk refused.
    """
    traces = folder / survey_folder.TRACES_FOLDER
    names = {one.name for one in folder.iterdir() if not is_temporary(one.name)}
    is_filled = traces.exists() and any(traces.iterdir())
    # The disk may have refused after the log, which comes last, had its name.
    logs = [folder / name for name in names.intersection(survey_folder.LOG_FILES)]
    if (
        is_filled
        or not names <= {*BEGUN, traces.name}
        or any(read_regular(path) != plan.line() for path in logs)
    ):
        raise SurveyRefusedError(
            Message(
                "{folder} exists already; choose another survey id: the window does so when you "
                "start again",
                folder=printable(folder),
            ),
            fault=NO_PLAN,
        )
    durable_files.remove_temporaries(folder)
    for name in BEGUN:
        durable_files.remove_file(folder / name)
    durable_files.ensure_folder(traces)
