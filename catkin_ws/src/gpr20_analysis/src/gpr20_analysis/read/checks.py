"""Checks of the parts of a survey's folder: manifest, photographs, bag and recording."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from gpr20_analysis.read.traces import of_other_survey
from gpr20_analysis.read.verdict import Verification
from gpr20_analysis.work import Progress
from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.regular_files import FileSum, sum_if_readable, sum_of_file
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import RecoveredSurvey, recover
from gpr20_survey.folder.survey_folder import BAG_FILE, DAMAGED_FOLDER, MCAP_FILE
from gpr20_survey.plan.markers import FOUND_FORMAT, PHOTOS, Found, found_of, present
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import TEXT_TYPE, recorded_log
from gpr20_survey.trace import trace_message

DATA = "traces and recording"
"""Name of the entry of the log that says that they are others than at the end."""
NOT_OF_CLOSED = (Kind.PLAN.value, Kind.END.value)


def is_sealed(recovered: RecoveredSurvey) -> bool:
    """Return whether a manifest describes the survey, which was not reopened since."""
    sealed = recovered.manifest
    return sealed is not None and sealed.is_binding(recovered.found.records)


def manifest_differences(folder: Path, recovered: RecoveredSurvey) -> List[Message]:
    """Return how a survey differs from its manifest; nothing if that describes it no more.

    Raises:
        OSError: The disk cannot be read.
    """
    sealed, log = recovered.manifest, recovered.found
    if sealed is None or not is_sealed(recovered):
        return []
    found = list(_file_differences(folder, sealed.files))
    # Only what may be said of a closed survey is an addition.
    found += [
        Message(
            "entry {number} of the log, of kind {kind}, was added after the survey was closed",
            number=one.number,
            kind=one.kind,
        )
        for one in sealed.since(log.records)
        if one.kind in NOT_OF_CLOSED
    ]
    if not sealed.covers(log.records) and sealed.log.number not in log.lost:
        found.append(
            Message(
                "the log does not have entry {sealed} as the manifest names it; its last one is "
                "entry {last}",
                sealed=sealed.log.number,
                last=log.records[-1].number,
            )
        )
    return [*found, *_photo_faults(folder, log.records)]


def has_other_data(description: Mapping[str, Any], sums: Mapping[str, Optional[FileSum]]) -> bool:
    """Return whether these traces and recording are others than when the survey ended."""
    return description.get(manifest.CONTENT) not in (None, manifest.content_sum(sums))


def found_in(records: Sequence[LogRecord]) -> List[Found]:
    """Return what the records of a log say was found; those of later versions are left out."""
    values = [one.values for one in records if one.kind == Kind.FOUND]
    return [found_of(one) for one in values if one.get("format") == FOUND_FORMAT]


def found_rows(folder: Path) -> List[Tuple[str, ...]]:
    """Return what people found in a survey's folder: a row for each candidate of each list.

    Candidate, x and y [mm], what, depth [mm], who, when, notes; the last record counts.
    """
    return [
        (
            *(one.candidate, f"{one.x_mm:.0f}", f"{one.y_mm:.0f}", one.what.value),
            "-" if one.depth_mm is None else f"{one.depth_mm:.0f}",
            *(one.who, one.time[:16], one.notes),
        )
        for one in present(found_in(recover(folder).found.records))
    ]


def _photo_faults(folder: Path, records: Sequence[LogRecord]) -> List[Message]:
    """Return which photographs are not there, or are not as they were.

    The log vouches for them, and not the manifest: each has the name of its SHA-256. One that no
    record names is left of an interruption.
    """
    try:
        names = {one.photo for one in found_in(records) if one.photo}
    except InvalidValueError as error:
        return [error.message]
    return [
        Message("{file} is missing, or is not the photograph of the log", file=f"{PHOTOS}/{name}")
        for name in names
        if getattr(sum_if_readable(folder / PHOTOS / name), "sha256", "") != name[:64]
    ]


def _file_differences(folder: Path, listed: Mapping[str, Optional[FileSum]]) -> Iterator[Message]:
    # Names from the manifest are only compared; only files found in the folder are opened.
    present = set(manifest.file_names(folder))
    for name in sorted(present | listed.keys()):
        # What is no data, a damaged file, may be put aside at any time.
        is_aside = name.startswith(f"{DAMAGED_FOLDER}/")
        if name not in present:
            yield Message("{file} is in the manifest but does not exist", file=name)
        elif name not in listed:
            if not is_aside:
                yield Message("{file} is not in the manifest", file=name)
        elif listed[name] is not None or not is_aside:
            try:
                if sum_of_file(folder / name) != listed[name]:
                    yield Message(
                        "{file} differs from the manifest: its size or SHA-256 has changed",
                        file=name,
                    )
            except OSError as error:
                yield _unreadable(name, error)


def _unreadable(name: str, error: OSError) -> Message:
    return Message("{file} cannot be read: {reason}", file=name, reason=os_reason(error))


def check_bag(
    folder: Path, records: Sequence[LogRecord], finished: bool, found: Verification
) -> None:
    """Compare survey.bag with the checksum in the log; without a bag the survey is complete.

    Nothing vouches for one that the log does not name.

    Args:
        folder: The survey's folder.
        records: Its log.
        finished: Whether the survey ended, so that it should have a bag.
        found: What is found is added here.
    """
    named = {"file": BAG_FILE, "folder": printable(folder)}
    if not os.path.lexists(str(folder / BAG_FILE)):
        if finished:
            found.notes.append(
                Message("{file} is missing; `gpr20 export --format bag {folder}` makes it", **named)
            )
        return
    try:
        present = sum_of_file(folder / BAG_FILE)
    except OSError as error:
        found.faults.append(_unreadable(BAG_FILE, error))
        return
    # A bag counts that was made since the survey was resumed last.
    made = [one for one in records if one.kind in (Kind.BAG.value, Kind.RESUME.value)][-1:]
    if not made or made[0].kind != Kind.BAG.value:
        found.notes.append(
            Message(
                "the log does not confirm {file}, as after a power cut; `gpr20 export --format bag "
                "{folder}` makes it again",
                **named,
            )
        )
        found.unconfirmed += (BAG_FILE,)
    elif (present.sha256, present.size) != tuple(map(made[0].values.get, ("sha256", "size"))):
        found.faults.append(
            Message(
                "{file} differs from its SHA-256 in the log; `gpr20 export --format bag {folder}` "
                "makes it again",
                **named,
            )
        )


def check_recording(
    folder: Path,
    recovered: RecoveredSurvey,
    stored: Mapping[int, bytes],
    progress: Progress,
    found: Verification,
) -> None:
    """Compare the recording of a survey with its traces and its log.

    Args:
        folder: The survey's folder.
        recovered: What its log says.
        stored: Fingerprint of each trace that has a readable JSON file.
        progress: Shows the progress.
        found: What is found is added here.
    """
    mcap = StoredMcap(folder / MCAP_FILE)
    if not os.path.lexists(str(mcap.path)):
        found.faults.append(Message("{file} is missing", file=MCAP_FILE))
        return
    recorded: Dict[int, bytes] = {}
    entries: List[LogRecord] = []
    faults: List[Message] = []
    try:
        for message in progress(mcap.messages(), None):
            if message.datatype == trace_message.DATATYPE:
                _take(message, recovered.survey_id, recorded, faults)
            elif message.datatype == TEXT_TYPE:
                entry = recorded_log(message)
                entries += [entry] if entry else []
    except (OSError, TraceRefusedError) as error:
        reason = os_reason(error) if isinstance(error, OSError) else error.message
        faults.append(
            Message("{file} cannot be read to its end: {reason}", file=MCAP_FILE, reason=reason)
        )
    faults += mcap.faults
    # A recording that is cut off is a fault of a survey that ended.
    finished = recovered.description.get("ended") is not None
    if finished and not faults and not mcap.is_finished():
        faults.append(
            Message("{file} has no complete end, although the survey ended", file=MCAP_FILE)
        )
    is_readable = not faults
    faults += [
        Message(
            "trace {index} has other values in {file} than in its JSON file",
            index=index,
            file=MCAP_FILE,
        )
        for index in sorted(recorded.keys() & stored.keys())
        if recorded[index] != stored[index]
    ]
    found.faults += faults
    if found.writer:
        return  # the recording was read later than files and log
    if is_readable:
        _compare(sorted(stored.keys() - recorded.keys()), finished, found)
    found.faults += [
        Message("trace {index} is in {file} but has no readable JSON file", index=index,
                file=MCAP_FILE)
        for index in sorted(recorded.keys() - stored.keys())
    ]  # fmt: skip
    _name_entries(entries, recovered.found.records, found)


def _take(
    message: RecordedMessage, survey_id: str, recorded: Dict[int, bytes], faults: List[Message]
) -> None:
    trace = trace_message.decode(message.data, message.md5sum)
    if trace.survey_id != survey_id:
        faults.append(Message("{file}: {reason}", file=MCAP_FILE, reason=of_other_survey(trace)))
    elif trace.index in recorded:
        faults.append(
            Message(
                "{file} contains trace {index} more than once", file=MCAP_FILE, index=trace.index
            )
        )
    else:
        recorded[trace.index] = trace.fingerprint()


def _compare(missing: List[int], finished: bool, found: Verification) -> None:
    # The JSON file is written first: a crash may come between it and the recording, but the
    # next trace is not stored before this one is in both.
    if len(missing) == 1 and not finished:
        found.notes.append(
            Message(
                "trace {index} is not in {file} yet; it is added when the survey is resumed",
                index=missing[0],
                file=MCAP_FILE,
            )
        )
        return
    found.faults += [
        Message("trace {index} has a JSON file but is not in {file}", index=index, file=MCAP_FILE)
        for index in missing
    ]


def _name_entries(
    recorded: Sequence[LogRecord], records: Sequence[LogRecord], found: Verification
) -> None:
    """Name the entries of the log that the recording alone holds."""
    known = {one.sha256 for one in records}
    for one in recorded:
        name = f"record {one.number}"
        is_named = {name, f"{name}, {one.sha256[:8]}"} & {*found.unconfirmed}
        if one.sha256 not in known and not is_named:
            found.notes.append(
                Message(
                    "entry {number} of the log, of kind {kind}, is in {file} alone",
                    number=one.number,
                    kind=one.kind,
                    file=MCAP_FILE,
                )
            )
            found.unconfirmed += (name,)
