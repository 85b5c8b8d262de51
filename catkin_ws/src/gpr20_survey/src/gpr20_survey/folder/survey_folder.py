"""Names of a survey's folder and files; none of them comes unchecked from outside."""

from __future__ import annotations

import re
from pathlib import Path
from typing import List

from gpr20_common.faults import FILE_DAMAGED
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.plan.markers import PHOTOS
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import SURVEY_ID, Trace

SURVEY_FILE = "survey.json"
LOG_FILE = "log.jsonl"
COPY_FILE = "log.copy.jsonl"
LOG_FILES = (LOG_FILE, COPY_FILE)
BAG_FILE = "survey.bag"
MCAP_FILE = "survey.mcap"
DAMAGED_FOLDER = "damaged"
TRACES_FOLDER = "traces"

EXAMPLE_FOLDER = "20260921T141320_0f8fad5b"
FOLDER_NAME = re.compile(r"[0-9]{8}T[0-9]{6}_[0-9a-f]{8}")


def check_survey_id(survey_id: str) -> str:
    """Return the id if it is a UUID in lower case with hyphens.

    Raises:
        SurveyRefusedError: It is anything else.
    """
    if not SURVEY_ID.fullmatch(survey_id):
        raise SurveyRefusedError(
            Message(
                "survey_id is {survey_id}; it must be a UUID in lower case with hyphens, such as "
                "{example}",
                survey_id=repr(survey_id[:64]),
                example="0f8fad5b-d9cb-469f-a165-70867728950e",
            )
        )
    return survey_id


def survey_folder(data: Path, survey_id: str, started_us: int) -> Path:
    """Return the folder of a survey that started then [us since 1970, UTC].

    Raises:
        SurveyRefusedError: The id is no UUID or the time cannot be right.
    """
    check_survey_id(survey_id)
    if not utc_time.is_plausible(started_us):
        raise SurveyRefusedError(
            Message(
                "the survey would start on {time}; set the computer's clock",
                time=utc_time.moment_text(utc_time.iso_text(started_us)),
            ),
            fault=faults.CLOCK_WRONG,
        )
    compact = re.sub("[-:]", "", utc_time.iso_text(started_us)[:19])  # to the second
    return data / f"{compact}_{survey_id[:8]}"


def candidate_folders(data: Path, survey: str) -> List[Path]:
    """Return the folders that may be meant by a survey's id or the name of its folder.

    Raises:
        SurveyRefusedError: The text is neither; nothing outside the data folder can be named.
    """
    if SURVEY_ID.fullmatch(survey):
        found = sorted(data.glob(f"*_{survey[:8]}"))
    elif FOLDER_NAME.fullmatch(survey):
        found = [data / survey]
    else:
        raise SurveyRefusedError(
            Message(
                "survey is {survey}; it must be a survey's id (a UUID in lower case) or the name "
                "of its folder, such as {example}",
                survey=repr(survey[:64]),
                example=EXAMPLE_FOLDER,
            ),
            fault=faults.UNKNOWN_SURVEY,
        )
    named = (one for one in found if FOLDER_NAME.fullmatch(one.name))
    return [one for one in named if one.is_dir() and not one.is_symlink()]


def check_no_links(folder: Path) -> None:
    """Check that all of a survey is in its folder: a link could lead out of the data folder.

    Raises:
        SurveyRefusedError: One of its files or folders is a symbolic link.
    """
    names = (SURVEY_FILE, *LOG_FILES, TRACES_FOLDER, BAG_FILE, MCAP_FILE, DAMAGED_FOLDER, PHOTOS)
    for path in (folder / name for name in names):
        if path.is_symlink():
            raise SurveyRefusedError(
                Message(
                    "{path} is a symbolic link, which is not followed; put the files there",
                    path=printable(path),
                ),
                fault=FILE_DAMAGED,
            )


def trace_file_name(trace: Trace) -> str:
    """Return the name of a trace's file, such as 000123_X0050.00_Y0050.00_Z+090.00.json.

    The index makes the name unique; the coordinates in it are for people.
    """
    x_mm, y_mm, z_deg = (
        round(value, 2) + 0.0  # never "-0.00"
        for value in (trace.x_coord_mm, trace.y_coord_mm, trace.z_coord_deg)
    )
    return f"{trace.index:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{z_deg:+07.2f}.json"
