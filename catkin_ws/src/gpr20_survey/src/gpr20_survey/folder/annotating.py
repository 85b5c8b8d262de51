"""Adding to a survey that is not open: annotation, markers and other facts."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Optional, Sequence

from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ManifestDamagedError, SurveyRefusedError, storing
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.folder import manifest, sealing, survey_folder
from gpr20_survey.folder.log_record import NOTES, Kind, LogRecord
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.recovery import is_vouched, open_log, recover_with_recording
from gpr20_survey.folder.signature import Signer, try_to_sign
from gpr20_survey.plan.annotation import Annotation, keeping_heading


class Fact(NamedTuple):
    """What is to be added to the log of a survey."""

    kind: Kind
    values: Dict[str, Any]

    def is_in(self, records: Sequence[LogRecord]) -> bool:
        """Return whether a log has this note: the answer to the first request may be lost.

        A note has its own time. Other facts may come again.
        """
        same = (self.kind.value, self.values)
        return self.kind in NOTES and same in ((one.kind, one.values) for one in records)


Change = Callable[[Dict[str, Any]], Optional[Fact]]
"""Takes the content of survey.json and returns what is added; None: it says that already."""


def annotate(annotation: Annotation) -> Change:
    """Return the change that replaces the annotation.

    Args:
        annotation: The new annotation, whole; its heading is that of the former one at this
            position.
    """

    def change(description: Dict[str, Any]) -> Fact:
        return Fact(Kind.ANNOTATION, keeping_heading(annotation, description).values())

    return change


def add_to_survey(
    folder: Path,
    change: Change,
    now: str,
    signer: Optional[Signer] = None,
    on_unsigned: Callable[[Message], None] = lambda _warning: None,
) -> Dict[str, Any]:
    """Add a fact to a survey that nobody writes; return survey.json's content when it is durable.

    A form of the log that is damaged is written again from the other one. A survey of an earlier
    version gets a log.

    Args:
        folder: The survey's folder.
        change: What is added.
        now: The present moment, as ISO 8601 text.
        signer: Signs the survey again, if its manifest was as this key had signed it.
        on_unsigned: Called with a warning if that failed.

    Raises:
        SurveyRefusedError: Nothing describes the survey, part of its log is lost, its manifest is
            damaged, another process writes it, or `change` refused.
        StorageFailedError: The disk refused; the call may be repeated.
    """
    survey_folder.check_no_links(folder)
    failure = Message("{path} could not be written", path=printable(folder))
    with storing(failure, folder), locked(folder, SHORT_WAIT_S):
        sealed = _seal_of(folder)
        recovered = recover_with_recording(folder)
        if recovered.found.lost:
            raise _damaged(folder, recovered.found.damage)
        if sealed is not None and sealed.log is not None:
            _check_covered(folder, sealed, recovered.found.records)
        elif sealed is not None and not is_vouched(folder):
            raise _damaged(folder, ())
        fact = change(recovered.description)
        if fact is not None and fact.is_in(recovered.found.records):
            fact = None
        if fact is None and recovered.found.is_whole:
            return recovered.description
        was_signed = signer is not None and signer.has_signed(folder)
        log = open_log(folder, recovered, now)
        if sealed is not None and not log.is_whole:
            sealed = sealing.write_sealed(folder, sealed, log)
        elif fact is None:
            log.write()
        if fact is not None:
            record = log.next(fact.kind, fact.values, now)
            if sealed is None:
                log.add(record)
            else:
                sealing.add_sealed(folder, sealed, log, record)
        warning = try_to_sign(signer, folder) if was_signed else None
    if warning is not None:
        on_unsigned(warning)
    return log.description


def _seal_of(folder: Path) -> Optional[Manifest]:
    """Return the manifest of a survey that is closed; None: it was cut off or reopened."""
    try:
        sealed = manifest.read_manifest(folder)
    except FileNotFoundError:
        return None
    except ManifestDamagedError as error:
        raise _manifest_damaged(folder, error.message) from error
    return sealed if sealed.reopened is None else None


def _check_covered(folder: Path, sealed: Manifest, records: Sequence[LogRecord]) -> None:
    if not sealed.covers(records):
        raise _manifest_damaged(
            folder, Message("the log of the survey does not end as the manifest says")
        )


def _manifest_damaged(folder: Path, reason: Message) -> SurveyRefusedError:
    return SurveyRefusedError(
        Message(
            "{path} is damaged: {reason}; gpr20 repair writes it again if all else is right",
            path=printable(folder / manifest.MANIFEST_FILE),
            reason=reason,
        ),
        fault=faults.MANIFEST_DAMAGED,
    )


def _damaged(folder: Path, damage: Sequence[Message]) -> SurveyRefusedError:
    reasons = in_a_row(damage) if damage else Message("survey.json differs from the manifest")
    return SurveyRefusedError(
        Message(
            "what is noted of the survey in {folder} is damaged: {reasons}; nothing was changed; "
            "resume the survey, which repairs it and names what is lost",
            folder=printable(folder),
            reasons=reasons,
        ),
        fault=faults.DESCRIPTION_DAMAGED,
    )
