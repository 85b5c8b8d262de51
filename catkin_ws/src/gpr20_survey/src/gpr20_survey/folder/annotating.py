"""Adding a fact to the log of a survey that is not open."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Optional

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError, storing
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import RecoveredSurvey, open_log, recover


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

    A file of the log that is damaged is written again from the other one.

    Args:
        folder: The survey's folder.
        change: What is added.
        now: The present moment, as ISO 8601 text.
        wait_s: How long to wait for another process that adds one [s].

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
                "or of another log; nothing was changed; `gpr20 repair`, or resuming the survey, "
                "names what is lost",
                count=count,
                folder=printable(folder),
            ),
            fault=faults.DESCRIPTION_DAMAGED,
        )
    try:
        if manifest.read_manifest(folder).covers(recovered.found.records):
            return
        reason = Message("the log of the survey does not end as the manifest says")
    except FileNotFoundError:
        return  # it was cut off, or reopened
    except ManifestDamagedError as error:
        reason = error.message
    raise SurveyRefusedError(
        Message(
            "{path} is damaged: {reason}; gpr20 repair writes it again if all else is right",
            path=printable(folder / manifest.MANIFEST_FILE),
            reason=reason,
        ),
        fault=faults.MANIFEST_DAMAGED,
    )
