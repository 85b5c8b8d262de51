"""What a survey's folder says of its survey, and what of that nothing vouches for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import (
    IrregularFileError,
    ManifestDamagedError,
    SurveyRefusedError,
)
from gpr20_survey.files import durable_files, file_sums
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.description_copies import is_of, sealed_description
from gpr20_survey.folder.log_content import START, UNCONFIRMED, description_of
from gpr20_survey.folder.log_reading import FoundLog, json_text, lost_entries, read_log
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS, markers_of
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.survey_topics import recorded_log
from gpr20_survey.trace import trace_message

NO_COPY = "no copy of survey.json confirms it"
PLAN = "plan"
LATER = "everything that was not recorded"
WRONG_FORM = "it is not as the storage writes it"
MAX_RESUMPTIONS = 100_000
# How survey.json begins.
FIRST_KEYS = ("format", "survey_id", "started")


@dataclass(frozen=True)
class RecoveredSurvey:
    """A survey as its folder describes it.

    Attributes:
        description: The content of survey.json, without the records of its log.
        found: Its log as it was found; a survey of an earlier version has none.
        unconfirmed: Names of entries that nothing vouches for, with the reason, which no record
            of the log names yet.
        left_out: Entries of `description` that cannot be used as they are.
    """

    description: Dict[str, Any]
    found: FoundLog
    unconfirmed: Dict[str, Any]
    left_out: Tuple[str, ...] = ()

    @property
    def survey_id(self) -> str:
        """UUID of the survey."""
        return str(self.description["survey_id"])

    @property
    def all_unconfirmed(self) -> Dict[str, Any]:
        """The entries that nothing vouches for, also those that the log names."""
        return {**self.description.get(UNCONFIRMED, {}), **self.unconfirmed}


def read_description(folder: Path) -> Dict[str, Any]:
    """Return the content of survey.json, repaired from the log or the MCAP where it is damaged.

    Raises:
        SurveyRefusedError: Nothing in the folder describes the survey.
    """
    return recover(folder).description


def recover(
    folder: Path, recorded: Iterable[LogRecord] = (), sealed: Optional[Manifest] = None
) -> RecoveredSurvey:
    """Return what a folder says of its survey; nothing is changed.

    Args:
        folder: The survey's folder.
        recorded: Records of its log that were found in a recording.
        sealed: Its manifest; None: it is read where the log is damaged.

    Raises:
        SurveyRefusedError: Nothing in it describes the survey.
    """
    recorded = list(recorded)
    try:
        found = read_log(folder, recorded, sealed)
        if sealed is None and (not found.agrees or found.lost):
            sealed = _seal_of(folder)
            found = read_log(folder, recorded, sealed)
    except SurveyRefusedError as error:
        copy = _sealed_for(folder)
        if copy is None:
            # Resuming, which repairs it as long as there is a copy, does not help.
            raise SurveyRefusedError(error.message, fault=faults.DESCRIPTION_LOST) from error
        return RecoveredSurvey(start_of(copy), FoundLog(), _later_lost())
    if not found.has_log:
        return _former(folder, found)
    if not found.records or found.records[0].kind != Kind.PLAN.value:
        found = _with_plan(folder, found, recorded, sealed)
    description = description_of(found.records)
    survey_metadata.check_format(description, folder / survey_folder.LOG_FILE)
    unconfirmed = lost_entries(found)["entries"]
    if found.has_open_end and (sealed is None or sealed.log is None):
        unconfirmed = {**unconfirmed, **_later_lost()}
    return RecoveredSurvey(description, found, unconfirmed)


def recover_with_recording(folder: Path, for_reading: bool = False) -> RecoveredSurvey:
    """Return what `recover` does, with the records of the log in the MCAP.

    They are not read if both forms of the log are as the manifest says.

    Args:
        folder: The survey's folder.
        for_reading: Whether it is enough that both forms agree, as for who reads a survey again
            and again while it is measured.

    Raises:
        SurveyRefusedError: Nothing in the folder describes the survey.
        OSError: The MCAP cannot be read.
    """
    sealed = _seal_of(folder)
    try:
        recovered = recover(folder, sealed=sealed)
        if _is_certain(recovered.found, sealed, for_reading):
            return recovered
    except SurveyRefusedError:
        pass  # what the MCAP holds decides
    records, was_opened = _records_in(StoredMcap(folder / survey_folder.MCAP_FILE))
    recovered = recover(folder, records, sealed)
    if was_opened or (recovered.found.has_log and recovered.found.agrees):
        return recovered
    # Nothing was acknowledged before the opening of the survey was.
    unconfirmed = {key: one for key, one in recovered.unconfirmed.items() if key != LATER}
    return replace(recovered, unconfirmed=unconfirmed)


def _is_certain(found: FoundLog, sealed: Optional[Manifest], for_reading: bool) -> bool:
    if not found.has_log:
        return for_reading or (sealed is not None and sealed.log is None)
    if not found.agrees or found.lost:
        return False
    return for_reading or (sealed is not None and sealed.covers(found.records))


def _records_in(mcap: StoredMcap) -> Tuple[List[LogRecord], bool]:
    """Return the records of the log, and whether more is there than opening a survey records."""
    records: List[LogRecord] = []
    others = has_traces = False
    try:
        for message in mcap.messages():
            others = True
            has_traces = has_traces or message.datatype == trace_message.DATATYPE
            record = recorded_log(message)
            if record is not None:
                records.append(record)
    except IrregularFileError:
        pass  # whoever reads the traces says so
    return records, has_traces or len(records) > 1 or (others and not records)


def start_of(description: Dict[str, Any]) -> Dict[str, Any]:
    """Return a description as it was when the survey began."""
    constant = {
        key: value for key, value in description.items() if key not in survey_metadata.LATER_KEYS
    }
    first = {key: constant[key] for key in FIRST_KEYS if key in constant}
    return {**first, **START, **constant}


def open_log(folder: Path, recovered: RecoveredSurvey, now: str) -> SurveyLog:
    """Return the log of a survey, whose folder must be locked; write it unless it is whole.

    A file that was damaged is kept in `damaged/`. The log of a survey of an earlier version begins
    with its survey.json. What nothing vouches for is named in the log, for ever.

    Args:
        folder: The survey's folder.
        recovered: What was found in it.
        now: The present moment, as ISO 8601 text.

    Raises:
        OSError: The disk refused; the call may be repeated.
    """
    found = recovered.found
    log = SurveyLog(folder, found.records, found.is_whole, found.lost)
    if found.damage or found.own is None:
        for name in (survey_folder.LOG_FILE, survey_folder.SURVEY_FILE):
            _keep_damaged(folder, name)
    if not found.records:
        kept = {
            key: value
            for key, value in recovered.description.items()
            if key not in recovered.left_out
        }
        log.take(log.next(Kind.PLAN, kept, now))
    if recovered.unconfirmed:
        # With the same write: after it nothing else shows that something is missing.
        values = {"entries": recovered.unconfirmed, "lost": list(found.lost)}
        log.take(log.next(Kind.UNCONFIRMED, values, now))
    return log


def _seal_of(folder: Path) -> Optional[Manifest]:
    try:
        sealed = manifest.read_manifest(folder)
    except (OSError, ManifestDamagedError):
        return None
    return sealed if is_of(folder, sealed.survey_id) else None


def repairs_of(recovered: RecoveredSurvey) -> List[Message]:
    """Return what `open_log` repairs, and what nothing vouches for, for people."""
    found = recovered.found
    repairs = [
        Message(
            "{damage}; wrote it again from the other copies of its entries", damage=one
        ).with_fault(faults.REPAIRED)
        for one in found.damage
    ]
    if recovered.unconfirmed:
        repairs.append(unconfirmed_message(recovered.unconfirmed))
    return repairs


def unconfirmed_message(entries: Mapping[str, Any]) -> Message:
    """Return the remark on entries that nothing vouches for."""
    return Message(
        "nothing vouches for {count} entries of survey.json: {names}; compare them with what you "
        "know",
        count=len(entries),
        names=", ".join(list(entries)[:10]),
    ).with_fault(faults.UNCONFIRMED)


def is_vouched(folder: Path) -> Optional[bool]:
    """Return whether survey.json is as its manifest says; None without a manifest that says it."""
    sealed = _seal_of(folder)
    if sealed is None:
        return None
    try:
        present = file_sums.sum_of_file(folder / survey_folder.SURVEY_FILE)
    except OSError:
        return None
    if sealed.matches(survey_folder.SURVEY_FILE, present):
        return True
    return None if sealed.reopened is not None else False


def _former(folder: Path, found: FoundLog) -> RecoveredSurvey:
    """Return a survey of an earlier version, which has no log."""
    assert found.own is not None
    own, left_out = found.own, _left_out(found.own)
    unconfirmed: Dict[str, Any] = {
        key: {"reason": WRONG_FORM, "found": [json_text(own[key])]} for key in left_out
    }
    if is_vouched(folder):
        return RecoveredSurvey(own, found, unconfirmed, left_out)
    later = {name: {"reason": NO_COPY} for name in _later_entries(own, left_out)}
    sealed = _sealed_for(folder)
    if sealed is None:
        unconfirmed = {PLAN: {"reason": NO_COPY}, **later, **unconfirmed}
        return RecoveredSurvey(own, found, unconfirmed, left_out)
    best = survey_metadata.with_start_of(own, sealed)
    return RecoveredSurvey(best, found, {**later, **unconfirmed}, left_out)


def _sealed_for(folder: Path) -> Optional[Dict[str, Any]]:
    path = folder / survey_folder.SURVEY_FILE
    if path.exists() and not path.is_file():
        return None  # the copy could not take its place
    return sealed_description(folder)


def _with_plan(
    folder: Path, found: FoundLog, recorded: List[LogRecord], sealed: Optional[Manifest]
) -> FoundLog:
    """Return the log with its first record, which survey.mcap holds too.

    Raises:
        SurveyRefusedError: It does not.
    """
    copy = _sealed_for(folder)
    if copy is not None:
        plan = LogRecord.after(None, Kind.PLAN, copy, str(copy.get("started")))
        after = next((one for one in found.records if one.number == 1), None)
        if after is None or after.previous == plan.sha256:
            return read_log(folder, [*recorded, plan], sealed)
    raise SurveyRefusedError(
        Message(
            "the first entry of the log in {folder}, which describes the survey, is damaged in "
            "every copy",
            folder=printable(folder),
        ),
        fault=faults.DESCRIPTION_LOST,
    )


def _left_out(own: Dict[str, Any]) -> Tuple[str, ...]:
    """Return the entries that the storage did not write so."""
    wrong = []
    resumed = own.get("resumed", [])
    if not isinstance(resumed, list) or len(resumed) >= MAX_RESUMPTIONS:
        wrong.append("resumed")
    if not isinstance(own.get("report", {}), dict):
        wrong.append("report")
    try:
        markers_of(own)
    except InvalidValueError:
        wrong.append(MARKERS)
    return tuple(wrong)


def _later_entries(own: Dict[str, Any], left_out: Tuple[str, ...]) -> List[str]:
    """Return the names of the entries that came after the start, key by key."""
    names = [key for key in (ANNOTATION, "report", "outcome") if own.get(key)]
    if MARKERS not in left_out:
        names += [f"{MARKERS}/{place}" for place, _ in enumerate(own.get(MARKERS, []))]
    return [name for name in names if name not in left_out]


def _later_lost() -> Dict[str, Any]:
    reason = {"reason": "survey.json and the end of log.jsonl cannot be read"}
    return {LATER: reason}


def _keep_damaged(folder: Path, name: str) -> None:
    path = folder / name
    if path.is_file() and not path.is_symlink():
        durable_files.keep_aside(path, folder / survey_folder.DAMAGED_FOLDER)
    elif path.is_symlink() or path.exists():
        durable_files.move_aside(path, folder / survey_folder.DAMAGED_FOLDER)
