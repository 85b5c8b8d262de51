"""Writing a damaged log or manifest again, if everything else in the survey agrees."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import List

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read import manifest_check
from gpr20_analysis.read.manifest_check import ManifestCheck
from gpr20_analysis.read.verification import check_survey_folder, verify_survey
from gpr20_common.message import Message, in_a_row
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.files import durable_files
from gpr20_survey.files.file_sums import sum_of_file
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import (
    RecoveredSurvey,
    open_log,
    recover,
    repairs_of,
)

SHOWN = 5
"""Number of differences that are named."""
VOUCHED = Message(
    "the log vouches for all of it: traces and recordings are those with which the survey ended"
)
OTHERS = Message(
    "traces or recordings were replaced as a whole after the survey ended: its log says what they "
    "were, and nothing vouches for those that are there"
)
OTHER_DATA = {manifest_check.DATA: {"reason": "they are not those with which the survey ended"}}


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
    """Write what of the log is damaged, and a missing or damaged manifest, of a closed survey.

    The traces and the recordings are not changed. What is damaged is kept in `damaged/`.

    Args:
        folder: The folder of one survey.
        revision: Version of the suite.
        now: The present moment, as ISO 8601 text.
        progress: Shows the progress of each pass over the traces.

    Raises:
        AnalysisError: It is no survey, the survey is not closed, or its files differ from a
            valid manifest.
        SurveyRefusedError: Nothing describes the survey, or another process writes it.
        OSError: The disk cannot be read or written.
    """
    check_survey_folder(folder)
    with locked(folder, SHORT_WAIT_S):
        survey_folder.check_no_links(folder)
        recovered = recover(folder, asking_manifest=True)
        return _repair(folder, recovered, revision, now, progress)


def _repair(
    folder: Path, recovered: RecoveredSurvey, revision: str, now: str, progress: Progress
) -> RepairResult:
    log = recovered.found
    found = manifest_check.check_manifest(folder, recovered)
    is_valid = found.is_binding and not found.differences
    if is_valid and log.is_whole and not recovered.unconfirmed:
        return RepairResult(Repair.NOT_NEEDED)
    ended = recovered.description.get("ended")
    if not is_valid:
        _refuse(found, ended is not None)
    verified = verify_survey(folder, progress, use_manifest=is_valid, repairing=True)
    if verified.faults:
        return RepairResult(Repair.IMPOSSIBLE, verified.faults, verified.notes)
    notes = [*verified.notes, *repairs_of(recovered)]
    if found.damage is not None:
        # It keeps its name until the new one replaces it in one step.
        damaged = folder / survey_folder.DAMAGED_FOLDER
        kept = durable_files.keep_aside(folder / manifest.MANIFEST_FILE, damaged)
        place = f"{damaged.name}/{kept.name}"
        notes.append(Message("the damaged manifest is kept as {file}", file=place))
    if is_valid:
        assert found.manifest is not None
        repaired = open_log(folder, recovered, now)
        repaired.write()
        if not found.manifest.covers(repaired.records):
            # The entry that it names is lost, which the log says now.
            found.manifest.write_for(folder, repaired.last)
        return RepairResult(Repair.WRITTEN, notes=notes)
    data = filter(manifest.is_content, manifest.file_names(folder))
    sums = {name: sum_of_file(folder / name) for name in data}
    is_other = manifest_check.has_other_data(recovered.description, sums)
    if is_other:
        recovered = replace(recovered, unconfirmed={**recovered.unconfirmed, **OTHER_DATA})
    reason = Message("it was missing") if found.damage is None else found.damage
    whole_log = open_log(folder, recovered, now)
    whole_log.add(whole_log.next(Kind.SEAL, {"reason": reason.sentence()}, now))
    whole_log.write_description()
    survey_id = recovered.survey_id
    manifest.write_manifest(folder, survey_id, whole_log.last, revision, str(ended), sums)
    notes.append(Message("manifest.json was written again"))
    return RepairResult(Repair.WRITTEN, notes=[*notes, OTHERS if is_other else VOUCHED])


def _refuse(found: ManifestCheck, has_ended: bool) -> None:
    if found.is_binding:
        raise AnalysisError(
            Message(
                "the manifest is whole, but files differ from it: {differences}; resume the "
                "survey, which repairs its files, or restore them from a copy",
                differences=in_a_row(found.differences[:SHOWN]),
            ).reporting_only(faults.NOT_INTACT)
        )
    if found.manifest is not None or not has_ended:
        raise AnalysisError(
            Message("the survey is not closed; resume it and stop it, which writes the manifest"),
            fault=CAN_RESUME,
        )
