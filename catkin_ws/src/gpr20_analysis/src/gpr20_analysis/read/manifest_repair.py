"""Writing a lost or damaged manifest again, if everything else in the survey agrees."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from pathlib import Path
from typing import List

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read import manifest_check
from gpr20_analysis.read.manifest_check import ManifestCheck, Seal
from gpr20_analysis.read.verification import check_survey_folder, verify_survey
from gpr20_common.message import Message, in_a_row
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, sealing, survey_folder, survey_metadata

SHOWN = 5
"""Number of differences that are named."""
NOT_VOUCHED = Message(
    "nothing can tell whether these were changed before now: how survey.json says that the survey "
    "ended, its report and notes, and messages that only one of the recordings contains"
)


class Repair(enum.Enum):
    """What became of the manifest."""

    NOT_NEEDED = "not needed"
    WRITTEN = "written"
    IMPOSSIBLE = "impossible"


@dataclass
class RepairResult:
    """The result of the repair of a manifest."""

    repair: Repair
    faults: List[Message] = field(default_factory=list)
    """Why it is impossible."""
    notes: List[Message] = field(default_factory=list)
    """What was done, and what it cannot vouch for."""


def repair_manifest(
    folder: Path, revision: str, now: str, progress: Progress = no_progress
) -> RepairResult:
    """Write the manifest of a closed survey again if it is missing or damaged.

    No other file is changed. A damaged manifest is kept in `damaged/`.

    Args:
        folder: The folder of one survey.
        revision: Version of the suite.
        now: The present moment, as ISO 8601 text.
        progress: Shows the progress of each pass over the traces.

    Raises:
        AnalysisError: It is no survey, the survey is not closed, or its files differ from a
            valid manifest.
        SurveyRefusedError: survey.json cannot be read.
        OSError: The disk cannot be read or written.
    """
    check_survey_folder(folder)
    path = folder / survey_folder.SURVEY_FILE
    description = survey_metadata.read_description(path)
    survey_folder.check_survey_id(description["survey_id"])
    found = manifest_check.check_manifest(folder, description["survey_id"])
    if found.seal is Seal.VALID and not found.differences:
        return RepairResult(Repair.NOT_NEEDED)
    _refuse(found, description.get("ended") is not None)
    verified = verify_survey(folder, progress, use_manifest=False)
    if verified.faults:
        return RepairResult(Repair.IMPOSSIBLE, verified.faults, verified.notes)
    notes = list(verified.notes)
    reason = Message("it was missing") if found.damage is None else found.damage
    old = folder / manifest.MANIFEST_FILE
    if found.seal is Seal.DAMAGED:
        notes.append(_put_aside(old, folder / survey_folder.DAMAGED_FOLDER))
    rewritten = ({"time": now, "reason": reason.sentence()},)
    sealing.write_manifest(
        folder, description["survey_id"], revision, description["ended"], rewritten=rewritten
    )
    notes.append(Message("all three forms of every trace agree; manifest.json was written again"))
    return RepairResult(Repair.WRITTEN, notes=[*notes, NOT_VOUCHED])


def _refuse(found: ManifestCheck, has_ended: bool) -> None:
    if found.seal is Seal.VALID:
        raise AnalysisError(
            Message(
                "the manifest is whole, but files differ from it: {differences}; resume the "
                "survey, which repairs its files, or restore them from a copy",
                differences=in_a_row(found.differences[:SHOWN]),
            ),
            fault=faults.FILES_DIFFER,
        )
    if found.seal is Seal.REOPENED or not has_ended:
        raise AnalysisError(
            Message("the survey is not closed; resume it and stop it, which writes the manifest"),
            fault=faults.NOT_CLOSED,
        )


def _put_aside(path: Path, folder: Path) -> Message:
    if path.is_file() and not path.is_symlink():
        # It keeps its name until the new one replaces it in one step.
        target = durable_files.keep_aside(path, folder)
    else:
        target = durable_files.move_aside(path, folder)
    return Message("the damaged manifest is kept as {file}", file=f"{folder.name}/{target.name}")
