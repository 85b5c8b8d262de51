"""Why the storage refuses a trace or a survey, for people."""

from __future__ import annotations

from pathlib import Path
from typing import Collection, List

from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError, TraceRefusedError
from gpr20_survey.folder.survey_folder import LOG_FILES
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing import faults

SHOWN = 5  # traces or entries that are named

CLOSING = Message("the survey is being closed; stop it again", details="close_survey").with_fault(
    faults.CLOSING
)


def trace_while_closing(trace: Trace) -> TraceRefusedError:
    """Return the error: the survey takes no more traces."""
    return TraceRefusedError(
        Message("{trace} is refused: {reason}", trace=trace.label, reason=CLOSING),
        fault=faults.CLOSING,
    )


def trace_of_another_survey(trace: Trace, open_survey_id: str) -> TraceRefusedError:
    """Return the error: the survey of a trace is not the one that is open."""
    return TraceRefusedError(
        Message(
            "{trace} belongs to survey {survey}, but {open_survey} is open",
            trace=trace.label,
            survey=trace.survey_id,
            open_survey=open_survey_id,
        ),
        fault=faults.OTHER_OPEN,
    )


def sample_stored(trace: Trace, stored_index: int) -> TraceRefusedError:
    """Return the error: the sample is already stored at another place in the plan."""
    return TraceRefusedError(
        Message(
            "sample {sample} is already stored with index {stored_index}, not {index}; every "
            "sample needs its own id",
            sample=trace.sample_id,
            stored_index=stored_index,
            index=trace.index,
        )
    )


def index_stored(trace: Trace, folder: Path) -> TraceRefusedError:
    """Return the error: another trace is already stored at this place in the plan."""
    return TraceRefusedError(
        Message(
            "{trace} is refused: index {index} is already stored with other content in {folder}, "
            "which was left alone",
            trace=trace.label,
            index=trace.index,
            folder=printable(folder),
        ),
        fault=faults.TRACE_ALREADY_STORED,
    )


def file_missing(trace: Trace, folder: Path) -> StorageFailedError:
    """Return the error: the trace is stored, but its JSON file was removed."""
    return StorageFailedError(
        Message(
            "{trace} is already stored, but its file is missing from {folder}; stop and resume "
            "the survey: its recordings hold the trace",
            trace=trace.label,
            folder=printable(folder),
        ),
        fault=faults.FILE_MISSING,
    )


def only_foreign_traces(folder: Path, survey_id: str) -> SurveyRefusedError:
    """Return the error: the log in a folder is not that of its traces."""
    return SurveyRefusedError(
        Message(
            "the log in {folder} is that of survey {survey}, but every readable trace there "
            "belongs to another; put the right files of the log, {files}, there",
            folder=printable(folder),
            survey=survey_id,
            files=", ".join(LOG_FILES),
        ),
        fault=faults.OTHER_DESCRIPTION,
    )


def survey_complete(folder: Path, stored: int) -> SurveyRefusedError:
    """Return the error: a survey that is finished cannot be reopened."""
    return SurveyRefusedError(
        Message(
            "the survey in {folder} is finished and complete with {stored} traces; nothing is "
            "left to measure, start a new survey",
            folder=printable(folder),
            stored=stored,
        ),
        fault=faults.COMPLETE,
    )


def imported(folder: Path) -> SurveyRefusedError:
    """Return the error: an imported survey has no plan that could be continued."""
    return SurveyRefusedError(
        Message(
            "the survey in {folder} was imported; it has no plan that could be continued",
            folder=printable(folder),
        ),
        fault=faults.IMPORTED,
    )


def traces_not_planned(folder: Path, misfits: List[Message]) -> SurveyRefusedError:
    """Return the error: stored traces are not those that the log plans."""
    return SurveyRefusedError(
        Message(
            "the survey in {folder} cannot be resumed: {misfits}; restore its log from a copy "
            "of the folder, or start a new survey; nothing was changed",
            folder=printable(folder),
            misfits=in_a_row(misfits[:SHOWN]),
            details=f"{len(misfits)} differences",
        ),
        fault=faults.TRACES_NOT_PLANNED,
    )


def check_one_of(place: str, value: str, allowed: Collection[str]) -> None:
    """Check a word of a request.

    Raises:
        SurveyRefusedError: It is not one of those allowed.
    """
    if value not in allowed:
        raise SurveyRefusedError(
            Message(
                "{place} is {value}; it must be one of {allowed}",
                place=place,
                value=repr(value[:64]),
                allowed=", ".join(allowed),
            )
        )
