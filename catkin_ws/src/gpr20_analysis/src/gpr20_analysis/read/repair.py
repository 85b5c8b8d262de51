"""Writing a damaged log or manifest again, if everything else in the survey agrees."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import List

from gpr20_analysis import __version__, errors
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read import checks
from gpr20_analysis.read.verification import check_survey_folder, verify_survey
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message, in_a_row
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.files import durable_files
from gpr20_survey.files.durable_files import SHORT_WAIT_S, locked
from gpr20_survey.files.regular_files import sum_of_file
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import RecoveredSurvey, open_log, recover, repairs_of
from gpr20_survey.trace import utc_time

SOFTWARE = f"gpr20 {__version__}"
SHOWN = 5
"""Number of differences that are named."""
NOT_NEEDED = Message("nothing was changed: every file is as in the manifest")
IMPOSSIBLE = Message(
    "nothing was changed: more than the log and the manifest is damaged; resume the survey, which "
    "repairs its files"
)
VOUCHED = Message(
    "the log vouches for all of it: traces and recordings are those with which the survey ended"
)
OTHERS = Message(
    "traces or recordings were replaced as a whole after the survey ended: its log says what they "
    "were, and nothing vouches for those that are there"
)
OTHER_DATA = {checks.DATA: {"reason": "they are not those with which the survey ended"}}


def repair_survey(folder: Path, progress: Progress = no_progress) -> List[Message]:
    """Write what of the log is damaged, and a missing or damaged manifest, of a closed survey.

    The traces and the recordings are not changed. What is damaged is kept in `damaged/`.

    Args:
        folder: The folder of one survey.
        progress: Shows the progress of each pass over the traces.

    Returns:
        What was done, and what it cannot vouch for.

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
        is_valid = _is_manifest_valid(folder, recovered)
        if is_valid and recovered.found.is_whole and not recovered.unconfirmed:
            return [NOT_NEEDED]
        verified = verify_survey(folder, progress, repairing=True)
        if verified.faults:
            return [IMPOSSIBLE]
        notes = [*verified.notes, *repairs_of(recovered)]
        now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
        if not is_valid:
            return [*notes, *_write_manifest(folder, recovered, now)]
        log = open_log(folder, recovered, now)
        log.write()
        sealed = recovered.manifest
        if sealed is not None and not sealed.covers(log.records):
            # The entry that it names is lost, which the log says now.
            sealed.write_for(folder, log.last)
        return notes


def _is_manifest_valid(folder: Path, recovered: RecoveredSurvey) -> bool:
    """Return whether the manifest holds; False: it is missing or damaged.

    Raises:
        AnalysisError: It holds no more, or the survey has not ended.
    """
    differences = checks.manifest_differences(folder, recovered)
    if differences:
        raise AnalysisError(
            Message(
                "the manifest is whole, but files differ from it: {differences}; resume the "
                "survey, which repairs its files, or restore them from a copy",
                differences=in_a_row(differences[:SHOWN]),
            ).reporting_only(errors.NOT_INTACT)
        )
    if checks.is_sealed(recovered):
        return True
    if recovered.manifest is not None or recovered.description.get("ended") is None:
        raise AnalysisError(
            Message("the survey is not closed; resume it and stop it, which writes the manifest"),
            fault=CAN_RESUME,
        )
    return False


def _write_manifest(folder: Path, recovered: RecoveredSurvey, now: str) -> List[Message]:
    """Write the manifest for what is there, and into the log why, and whether it is as it was."""
    notes, reason = [], Message("it was missing")
    if recovered.manifest_damage is not None:
        reason = recovered.manifest_damage
        # It keeps its name until the new one replaces it in one step.
        damaged = folder / survey_folder.DAMAGED_FOLDER
        kept = durable_files.keep_aside(folder / manifest.MANIFEST_FILE, damaged)
        place = f"{damaged.name}/{kept.name}"
        notes.append(Message("the damaged manifest is kept as {file}", file=place))
    data = filter(manifest.is_content, manifest.file_names(folder))
    sums = {name: sum_of_file(folder / name) for name in data}
    is_other = checks.has_other_data(recovered.description, sums)
    if is_other:
        recovered = replace(recovered, unconfirmed={**recovered.unconfirmed, **OTHER_DATA})
    log = open_log(folder, recovered, now)
    log.add(log.next(Kind.SEAL, {"reason": reason.sentence()}, now))
    log.write_description()
    ended = str(recovered.description.get("ended"))
    manifest.write_manifest(folder, recovered.survey_id, log.last, SOFTWARE, ended, sums)
    return [*notes, Message("manifest.json was written again"), OTHERS if is_other else VOUCHED]
