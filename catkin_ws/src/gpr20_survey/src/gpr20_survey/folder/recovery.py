"""What a survey's folder says of its survey, what nothing vouches for, and how facts are added."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError, storing
from gpr20_survey.files import durable_files
from gpr20_survey.files.durable_files import SHORT_WAIT_S, locked
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import UNCONFIRMED, Kind, description_of
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.survey_log import FoundLog, SurveyLog, read_log
from gpr20_survey.folder.survey_metadata import FORMAT
from gpr20_survey.trace import utc_time


@dataclass(frozen=True)
class RecoveredSurvey:
    """A survey as its log describes it."""

    description: Dict[str, Any]
    """What the log says, with all entries that nothing vouches for."""
    found: FoundLog
    unconfirmed: Dict[str, Any]
    """Names of entries that nothing vouches for, with the reason, which the log lacks yet."""
    manifest: Optional[Manifest] = None
    """None: there is none, it is damaged, or nobody asked for it."""
    manifest_damage: Optional[Message] = None
    """What is wrong with it."""

    @property
    def survey_id(self) -> str:
        return str(self.description["survey_id"])


def read_description(folder: Path) -> Dict[str, Any]:
    """Return what the log of a survey says of it.

    Raises:
        SurveyRefusedError: Nothing in the folder describes the survey.
    """
    return recover(folder).description


def recover(folder: Path, asking_manifest: bool = False) -> RecoveredSurvey:
    """Return what a folder says of its survey; nothing is changed.

    A log that ends before its manifest was written counts as damaged. With `asking_manifest` the
    whole manifest is read although the log has the entry that it names, which takes longer.

    Raises:
        SurveyRefusedError: Nothing in it describes the survey, or it is of another version.
    """
    found, sealed, damage = read_log(folder), None, None
    if asking_manifest or not found.is_whole or not manifest.may_cover(folder, found.records):
        try:
            sealed = manifest.read_manifest(folder)
            found = read_log(folder, sealed)
        except FileNotFoundError:
            pass
        except ManifestDamagedError as error:
            damage = error.message
    first = found.records[0] if found.records else None
    if first is None or first.kind != Kind.PLAN or first.number != 0:
        raise SurveyRefusedError(
            Message(
                "the first entry of the log in {folder}, which describes the survey, is missing or "
                "damaged in {files}",
                folder=printable(folder),
                files=", ".join(survey_folder.LOG_FILES),
            ),
            fault=faults.LOG_LOST,
        )
    try:
        description = description_of(found.records)
        if description["format"] != FORMAT:
            raise ValueError(repr(description["format"])[:256])
        survey_folder.check_survey_id(description["survey_id"])
        utc_time.parse_iso(description["started"])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        # One such survey must not prevent the others from being listed.
        raise SurveyRefusedError(
            Message(
                "the log in {folder} is not as this software writes it, in the format {format}",
                folder=printable(folder),
                format=FORMAT,
                details=error,
            ),
            fault=faults.DAMAGED,
        ) from error
    unconfirmed = found.lost_entries()
    if unconfirmed:
        description[UNCONFIRMED] = {**description.get(UNCONFIRMED, {}), **unconfirmed}
    if sealed is not None and sealed.survey_id != description["survey_id"]:
        damage = Message("it is the manifest of survey {survey}", survey=sealed.survey_id)
        sealed = None
    return RecoveredSurvey(description, found, unconfirmed, sealed, damage)


def open_log(folder: Path, recovered: RecoveredSurvey, now: str) -> SurveyLog:
    """Return the log of a survey, whose folder must be locked; the next record makes it whole.

    A file that was damaged is kept in `damaged/`. What nothing vouches for is named in the log,
    for ever, with the present moment as ISO 8601 text.

    Raises:
        OSError: The disk refused; the call may be repeated.
    """
    found = recovered.found
    log = SurveyLog(folder, found.records, found.is_whole, found.lost)
    for name in found.damaged:
        if (folder / name).is_symlink() or (folder / name).exists():
            durable_files.keep_aside(folder / name, folder / survey_folder.DAMAGED_FOLDER)
    if recovered.unconfirmed:
        # With the same write: after it nothing else shows that something is missing.
        values = {"entries": recovered.unconfirmed, "lost": list(found.lost)}
        log.take(log.next(Kind.UNCONFIRMED, values, now))
    return log


def repairs_of(recovered: RecoveredSurvey) -> List[Message]:
    """Return what `open_log` repairs, and what nothing vouches for, for people."""
    repairs = [
        Message(
            "{file} is damaged; wrote it again from the other file of the log", file=one
        ).with_fault(faults.DAMAGED.as_warning())
        for one in recovered.found.damaged
    ]
    if recovered.unconfirmed:
        repairs.append(unconfirmed_message(recovered.unconfirmed))
    return repairs


def unconfirmed_message(entries: Mapping[str, Any]) -> Message:
    """Return the remark on entries that nothing vouches for."""
    return Message(
        "nothing vouches for {count} entries of the survey: {names}; compare them with what you "
        "know",
        count=len(entries),
        names=", ".join(list(entries)[:10]),
    ).with_fault(faults.UNCONFIRMED)


def find_survey(data: Path, survey: str) -> Tuple[Path, RecoveredSurvey]:
    """Return a survey's folder, by its name or the survey's id, and what it says of its survey.

    Raises:
        SurveyRefusedError: There is none, nothing in its folder describes it, part of it is a
            symbolic link, or several folders hold the survey of an id.
        StorageFailedError: A file cannot be read.
    """
    reason = Message(
        "there is no survey {survey} in {folder}", survey=repr(survey[:64]), folder=printable(data)
    )
    every = []
    for folder in survey_folder.candidate_folders(data, survey):
        survey_folder.check_no_links(folder)
        failure = Message("the survey in {folder} could not be read", folder=printable(folder))
        with storing(failure, folder):
            found = recover(folder)
        survey_id = found.survey_id
        if survey in (folder.name, survey_id) and folder.name.endswith(f"_{survey_id[:8]}"):
            every.append((folder, found))
        reason = Message(
            "{folder} holds survey {found}, not {survey}",
            folder=printable(folder),
            found=survey_id,
            survey=survey[:64],
        )
    if len(every) == 1:
        return every[0]
    if every:
        reason = Message(
            "survey {survey} is in {folders}; give the name of the folder that is meant",
            survey=survey,
            folders=", ".join(folder.name for folder, _found in every),
        )
    raise SurveyRefusedError(reason, fault=faults.UNKNOWN_SURVEY)


class Fact(NamedTuple):
    """What is to be added to the log of a survey."""

    kind: Kind
    values: Dict[str, Any]


Change = Callable[[Dict[str, Any]], Optional[Fact]]
"""Takes what the log says of the survey and returns what is added; None: it says that already."""


def add_to_survey(
    folder: Path, change: Change, now: str, wait_s: float = SHORT_WAIT_S
) -> Dict[str, Any]:
    """Add a fact to a survey that nobody writes; return what its log says when it is durable.

    A file of the log that is damaged is written again from the other one. `now` is ISO 8601 text;
    for another process that adds a fact it waits a while [s].

    Raises:
        SurveyRefusedError: Nothing describes the survey, part of its log is lost, its manifest is
            damaged, another process writes it, or `change` refused.
        StorageFailedError: The disk refused; the call may be repeated.
    """
    survey_folder.check_no_links(folder)
    failure = Message("{path} could not be written", path=printable(folder))
    with storing(failure, folder), locked(folder, wait_s):
        recovered = recover(folder, asking_manifest=True)
        _check(folder, recovered)
        fact = change(recovered.description)
        log = open_log(folder, recovered, now)
        if fact is not None and not log.has_note(*fact):
            log.add(log.next(fact.kind, fact.values, now))
        elif not log.is_whole:
            log.write()
    return log.description


def _check(folder: Path, recovered: RecoveredSurvey) -> None:
    """Refuse a survey of which something is lost: what was said of it must be looked at first."""
    count = len(recovered.found.lost) + len(recovered.found.strangers)
    if count:
        raise SurveyRefusedError(
            Message(
                "{count} entries of the log of the survey in {folder} are damaged in both files, "
                "or of another log; nothing was changed; `gpr20 verify --repair`, or resuming the "
                "survey, names what is lost",
                count=count,
                folder=printable(folder),
            ),
            fault=faults.CAN_RESUME,
        )
    sealed, reason = recovered.manifest, recovered.manifest_damage
    if sealed is not None and not sealed.covers(recovered.found.records):
        reason = Message("the log of the survey does not end as the manifest says")
    if reason is None:
        return  # there may be none: it was cut off, or reopened
    raise SurveyRefusedError(
        Message(
            "{path} is damaged: {reason}; gpr20 verify --repair writes it again if all else is "
            "right",
            path=printable(folder / manifest.MANIFEST_FILE),
            reason=reason,
        ),
        fault=faults.MANIFEST_DAMAGED,
    )
