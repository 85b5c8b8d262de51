"""Checks of the parts of a survey's folder: manifest, photographs, bag, recording, description."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence

from gpr20_analysis.read.traces import of_other_survey
from gpr20_analysis.work import Progress
from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.file_sums import FileSum, sum_if_readable, sum_of_file
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.recovery import RecoveredSurvey
from gpr20_survey.folder.survey_folder import BAG_FILE, DAMAGED_FOLDER, MCAP_FILE
from gpr20_survey.folder.survey_log import FoundLog
from gpr20_survey.plan.robot_description import is_simulated_identity
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.survey_topics import TEXT_TYPE, recorded_log
from gpr20_survey.results.found import FORMAT, PHOTOS, Found, found_of
from gpr20_survey.trace import trace_message

DATA = "traces and recording"
"""Name of the entry of the log that says that they are others than at the end."""
NOT_OF_CLOSED = (Kind.PLAN.value, Kind.END.value)


@dataclass
class Checked:
    """What a check found."""

    faults: List[Message] = field(default_factory=list)
    notes: List[Message] = field(default_factory=list)
    unconfirmed: List[str] = field(default_factory=list)
    """Names of what nothing vouches for."""


@dataclass
class ManifestCheck:
    """The result of the check of the manifest."""

    manifest: Optional[Manifest] = None
    """None: it is missing or damaged."""
    is_binding: bool = False
    """Whether it describes the survey, which was not reopened since."""
    damage: Optional[Message] = None
    """What is wrong with the manifest itself."""
    differences: List[Message] = field(default_factory=list)
    """Differences between the survey and a binding manifest."""


def check_manifest(folder: Path, recovered: RecoveredSurvey) -> ManifestCheck:
    """Compare a survey's files with its manifest, as it was recovered with the survey.

    Raises:
        OSError: The disk cannot be read.
    """
    sealed, log = recovered.manifest, recovered.found
    if sealed is None:
        return ManifestCheck(damage=recovered.manifest_damage)
    if not sealed.is_binding(log.records):
        return ManifestCheck(sealed)
    differences = [*_differences(folder, sealed), *_other_log(sealed, log)]
    differences += _photo_faults(folder, log.records)
    return ManifestCheck(sealed, is_binding=True, differences=differences)


def has_other_data(description: Mapping[str, Any], sums: Mapping[str, Optional[FileSum]]) -> bool:
    """Return whether these traces and recording are others than when the survey ended."""
    return description.get(manifest.CONTENT) not in (None, manifest.content_sum(sums))


def found_in(records: Sequence[LogRecord]) -> List[Found]:
    """Return what the records of a log say was found; those of later versions are left out."""
    values = [one.values for one in records if one.kind == Kind.FOUND]
    return [found_of(one) for one in values if one.get("format") == FORMAT]


def _photo_faults(folder: Path, records: Sequence[LogRecord]) -> List[Message]:
    """Return which photographs are not there, or are not as they were.

    The log vouches for them, and not the manifest: each has the name of its SHA-256. One that no
    record names is left of an interruption.
    """
    try:
        names = {one.photo: one.photo[:64] for one in found_in(records) if one.photo}
    except InvalidValueError as error:
        return [error.message]
    return [
        Message("{file} is missing, or is not the photograph of the log", file=f"{PHOTOS}/{name}")
        for name, own in names.items()
        if getattr(sum_if_readable(folder / PHOTOS / name), "sha256", "") != own
    ]


def _differences(folder: Path, sealed: Manifest) -> Iterator[Message]:
    listed, present = sealed.files.keys(), set(manifest.file_names(folder))
    for name in sorted(listed - present):
        yield Message("{file} is in the manifest but does not exist", file=name)
    for name in sorted(present - listed):
        if not _is_put_aside(name):
            yield Message("{file} is not in the manifest", file=name)
    # Names from the manifest are only compared; only files found in the folder are opened.
    for name in sorted(present & listed):
        expected = sealed.files[name]
        if expected is None and _is_put_aside(name):
            continue  # it could not be read at the close
        try:
            if sum_of_file(folder / name) != expected:
                yield Message(
                    "{file} differs from the manifest: its size or SHA-256 has changed", file=name
                )
        except OSError as error:
            yield Message("{file} cannot be read: {reason}", file=name, reason=os_reason(error))


def _is_put_aside(name: str) -> bool:
    """Return whether a file is no data: a damaged one, which may be put aside at any time."""
    return name.startswith(f"{DAMAGED_FOLDER}/")


def _other_log(sealed: Manifest, log: FoundLog) -> Iterator[Message]:
    # Only what may be said of a closed survey is an addition.
    for one in sealed.since(log.records):
        if one.kind in NOT_OF_CLOSED:
            yield Message(
                "entry {number} of the log, of kind {kind}, was added after the survey was closed",
                number=one.number,
                kind=one.kind,
            )
    if not sealed.covers(log.records) and sealed.log.number not in log.lost:
        yield Message(
            "the log does not have entry {sealed} as the manifest names it; its last one is entry "
            "{last}",
            sealed=sealed.log.number,
            last=log.records[-1].number,
        )


def check_bag(folder: Path, records: Sequence[LogRecord], finished: bool) -> Checked:
    """Compare survey.bag with the checksum in the log; without a bag the survey is complete.

    Nothing vouches for one that the log does not name.

    Args:
        folder: The survey's folder.
        records: Its log.
        finished: Whether the survey ended, so that it should have a bag.
    """
    found, expected, path = Checked(), _recorded_bag(records), folder / BAG_FILE
    named = {"file": BAG_FILE, "folder": printable(folder)}
    if not os.path.lexists(str(path)):
        if finished:
            found.notes.append(
                Message("{file} is missing; `gpr20 export --format bag {folder}` makes it", **named)
            )
        return found
    try:
        present = sum_of_file(path)
    except OSError as error:
        reason = os_reason(error)
        found.faults.append(
            Message("{file} cannot be read: {reason}", file=BAG_FILE, reason=reason)
        )
        return found
    if expected is None:
        found.notes.append(
            Message(
                "the log does not confirm {file}, as after a power cut; `gpr20 export --format bag "
                "{folder}` makes it again",
                **named,
            )
        )
        found.unconfirmed.append(BAG_FILE)
    elif present != expected:
        found.faults.append(
            Message(
                "{file} differs from its SHA-256 in the log; `gpr20 export --format bag {folder}` "
                "makes it again",
                **named,
            )
        )
    return found


def _recorded_bag(records: Sequence[LogRecord]) -> Optional[FileSum]:
    """Return the checksum of a bag that was made since the survey was resumed last."""
    for record in reversed(records):
        if record.kind == Kind.BAG.value:
            return FileSum(str(record.values.get("sha256")), record.values.get("size", -1))
        if record.kind == Kind.RESUME.value:
            return None
    return None


def check_recording(
    folder: Path,
    survey_id: str,
    stored: Mapping[int, bytes],
    finished: bool,
    written: bool,
    progress: Progress,
) -> Checked:
    """Compare the traces of a survey's recording with its JSON files.

    Args:
        folder: The survey's folder.
        survey_id: UUID of the survey.
        stored: Fingerprint of each trace that has a readable JSON file.
        finished: Whether the survey ended, so that its recording was finished.
        written: Whether somebody writes the survey: the recording is read later than the files.
        progress: Shows the progress.
    """
    found, mcap = Checked(), StoredMcap(folder / MCAP_FILE)
    if not os.path.lexists(str(mcap.path)):
        return Checked([Message("{file} is missing", file=MCAP_FILE)])
    recorded = _recorded_prints(mcap, survey_id, len(stored), found, progress)
    # What is damaged in the file; that it is cut off is a fault of an ended survey.
    found.faults += mcap.faults
    if finished and not found.faults and not mcap.is_finished():
        found.faults.append(
            Message("{file} has no complete end, although the survey ended", file=MCAP_FILE)
        )
    if not found.faults and not written:
        _check_missing(sorted(stored.keys() - recorded.keys()), finished, found)
    templates = (
        (
            sorted(one for one in recorded.keys() & stored.keys() if recorded[one] != stored[one]),
            Message(
                "trace {index} has other values in {file} than in its JSON file",
                index=0,
                file=MCAP_FILE,
            ),
        ),
        (
            sorted(() if written else recorded.keys() - stored.keys()),
            Message(
                "trace {index} is in {file} but has no readable JSON file", index=0, file=MCAP_FILE
            ),
        ),
    )
    for indices, template in templates:
        found.faults += [template.with_values({"index": one}) for one in indices]
    return found


def _recorded_prints(
    mcap: StoredMcap, survey_id: str, expected: int, found: Checked, progress: Progress
) -> Dict[int, bytes]:
    """Return the fingerprint of each trace of the recording."""
    prints: Dict[int, bytes] = {}
    try:
        for message in progress(mcap.messages(trace_message.DATATYPE), expected):
            trace = trace_message.decode(message.data, message.md5sum)
            if trace.survey_id != survey_id:
                reason = of_other_survey(trace)
                found.faults.append(Message("{file}: {reason}", file=MCAP_FILE, reason=reason))
            elif trace.index in prints:
                found.faults.append(
                    Message(
                        "{file} contains trace {index} more than once",
                        file=MCAP_FILE,
                        index=trace.index,
                    )
                )
            else:
                prints[trace.index] = trace.fingerprint()
    except (OSError, TraceRefusedError) as error:
        reason = os_reason(error) if isinstance(error, OSError) else error.message
        found.faults.append(
            Message("{file} cannot be read to its end: {reason}", file=MCAP_FILE, reason=reason)
        )
    return prints


def _check_missing(missing: List[int], finished: bool, found: Checked) -> None:
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


def check_recorded_log(folder: Path, records: Sequence[LogRecord], named: Sequence[str]) -> Checked:
    """Find the entries of the log that the recording alone holds.

    Args:
        folder: The survey's folder.
        records: The survey's log.
        named: What is unconfirmed already.
    """
    found, known = Checked(), {one.sha256 for one in records}
    with contextlib.suppress(OSError):  # that it cannot be read is said already
        for message in StoredMcap(folder / MCAP_FILE).messages(TEXT_TYPE):
            record = recorded_log(message)
            if record is None or record.sha256 in known:
                continue
            name = f"record {record.number}"
            if not {name, f"{name}, {record.sha256[:8]}"} & {*named, *found.unconfirmed}:
                found.notes.append(
                    Message(
                        "entry {number} of the log, of kind {kind}, is in {file} alone",
                        number=record.number,
                        kind=record.kind,
                        file=MCAP_FILE,
                    )
                )
                found.unconfirmed.append(name)
    return found


def contradictions(description: Mapping[str, Any]) -> Iterator[Message]:
    """Yield where the entry `simulated` contradicts what measured the survey."""
    simulated = description.get("simulated")
    if not isinstance(simulated, bool):
        return
    instrument = description.get("instrument")
    identity = instrument.get("identity") if isinstance(instrument, dict) else None
    if isinstance(identity, str) and is_simulated_identity(identity) is not simulated:
        yield Message(
            "the survey says simulated: {simulated}, but the analyzer's identity is {identity}",
            simulated=_json(simulated),
            identity=identity,
        )
    nodes = description.get("nodes", [])
    for node in nodes if isinstance(nodes, list) else [nodes]:
        values = node if isinstance(node, dict) else {}
        if values.get("simulated") is not simulated:
            yield Message(
                "the survey says simulated: {simulated}, but for node {node} it says "
                "{node_simulated}",
                simulated=_json(simulated),
                node=str(values.get("name", node)),
                node_simulated=_json(values.get("simulated")),
            )


def _json(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)
