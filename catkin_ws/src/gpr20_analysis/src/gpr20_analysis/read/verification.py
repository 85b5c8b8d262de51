"""Verification of a survey's folder: files, values, positions, recordings."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Dict, List, Optional, Union

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read import checks, doubts
from gpr20_analysis.read.sources import whole_description
from gpr20_analysis.read.survey_grid import Plan
from gpr20_analysis.read.traces import Sample
from gpr20_analysis.read.verdict import Verification
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.faults import MANIFEST_DAMAGED
from gpr20_survey.files.folder_lock import writer_of
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import UNCONFIRMED, Kind
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.recovery import RecoveredSurvey, recover
from gpr20_survey.plan.imported import import_of, import_sentence, is_imported
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import moment_text

FILES = (
    survey_folder.SURVEY_FILE,
    *survey_folder.LOG_FILES,
    survey_folder.TRACES_FOLDER,
    survey_folder.BAG_FILE,
    survey_folder.MCAP_FILE,
)
REMEDY = Message(
    "gpr20 verify --repair compares everything else and, if all of it agrees, writes it again"
)


def check_survey_folder(folder: Path) -> None:
    """Check that a folder contains any part of a survey.

    Raises:
        AnalysisError: It does not.
    """
    if not any(os.path.lexists(str(folder / name)) for name in FILES):
        raise AnalysisError(
            Message(
                "{folder} is not the folder of a survey: it contains none of {names}",
                folder=folder,
                names=", ".join(FILES),
            ),
            fault=faults.INPUT,
        )


def verify_survey(
    folder: Union[str, Path],
    progress: Progress = no_progress,
    use_manifest: bool = True,
    repairing: bool = False,
) -> Verification:
    """Check a survey's folder; nothing in it is changed.

    Args:
        folder: The folder of one survey.
        progress: Shows the progress of each pass over its traces.
        use_manifest: False: check it as if it had no manifest, so everything else is compared.
        repairing: Whether the caller holds the folder's lock and writes the log again.

    Raises:
        AnalysisError: It is not the folder of a survey.
        OSError: The disk cannot be read.
    """
    folder = Path(folder).expanduser()
    check_survey_folder(folder)
    writer = None if repairing else writer_of(folder)
    try:
        survey_folder.check_no_links(folder)
        recovered = recover(folder, asking_manifest=True)
    except SurveyRefusedError as error:
        return Verification(faults=[error.message])
    verifier = _Verifier(folder, recovered, progress, use_manifest, writer)
    return verifier.run(with_log=not repairing)


class _Verifier:
    def __init__(
        self,
        folder: Path,
        recovered: RecoveredSurvey,
        progress: Progress,
        use_manifest: bool,
        writer: Optional[str],
    ) -> None:
        self._folder = folder
        self._progress = progress
        self._use_manifest = use_manifest
        self._recovered = recovered
        self._description = description = recovered.description
        self._survey_id: str = description["survey_id"]
        self._indexed = description.get("ended") is not None  # its recording was finished
        interrupted = description.get("outcome") == survey_metadata.INTERRUPTED
        self._found = Verification(
            closed=self._indexed and not interrupted,
            writer=writer or "",
            imported=import_sentence(description) if is_imported(description) else None,
        )
        self._samples: List[Sample] = []

    def run(self, with_log: bool) -> Verification:
        if self._use_manifest and not self._found.writer:
            self._check_manifest()
        if with_log:
            self._check_log()
        plan = self._plan()
        files = trace_files.read_all(
            self._folder / survey_folder.TRACES_FOLDER,
            self._survey_id,
            lambda paths: iter(self._progress(paths, len(paths))),
            lambda trace: self._check_trace(plan, trace),
        )
        for path, reason in files.damaged:
            self._found.faults.append(
                Message("{file} is not an intact trace: {reason}", file=path.name, reason=reason)
            )
        self._doubt()
        records, is_written = self._recovered.found.records, bool(self._found.writer)
        self._found.take(
            checks.check_recording(
                self._folder,
                self._survey_id,
                files.prints,
                self._indexed,
                is_written,
                self._progress,
            )
        )
        if not is_written:
            named = self._found.unconfirmed
            self._found.take(checks.check_recorded_log(self._folder, records, named))
            has_bag = self._indexed and self._found.imported is None
            self._found.take(checks.check_bag(self._folder, records, has_bag))
        self._check_description(len(files.prints))
        return self._found

    def _check_manifest(self) -> None:
        found = checks.check_manifest(self._folder, self._recovered)
        self._found.sealed = found.is_binding
        self._found.faults += found.differences
        if found.damage is not None:
            self._found.faults.append(
                Message(
                    "manifest.json is damaged: {reason}; {remedy}",
                    reason=found.damage,
                    remedy=REMEDY,
                ).reporting_only(MANIFEST_DAMAGED)
            )
        elif found.manifest is None and self._found.closed:
            self._found.faults.append(
                Message(
                    "manifest.json is missing, so changes to files cannot be detected: it was "
                    "removed, or the survey was cut off while it was closed; {remedy}",
                    remedy=REMEDY,
                ).with_fault(MANIFEST_DAMAGED)
            )
        elif found.manifest is None:
            self._found.notes.append(Message("the survey was not closed, so there is no manifest"))
        else:
            self._note_manifest(found.manifest)
            self._check_content(found.manifest)
        if (self._folder / survey_folder.DAMAGED_FOLDER).is_dir():
            self._found.notes.append(
                Message(
                    "{folder}/ contains damaged files that were replaced",
                    folder=survey_folder.DAMAGED_FOLDER,
                )
            )

    def _note_manifest(self, sealed: Manifest) -> None:
        for one in self._recovered.found.records:
            if one.kind == Kind.RESUME.value and one.number > sealed.log.number:
                self._found.notes.append(
                    Message(
                        "the manifest is from before the survey was reopened at {time}",
                        time=moment_text(one.time),
                    )
                )
            elif one.kind == Kind.SEAL.value:
                self._found.notes.append(
                    Message(
                        "the manifest was written again at {time}: {reason}; what was changed "
                        "before is not covered",
                        time=moment_text(one.time),
                        reason=str(one.values.get("reason")),
                    )
                )

    def _check_content(self, sealed: Manifest) -> None:
        is_named = checks.DATA in self._description.get(UNCONFIRMED, {})
        is_other = checks.has_other_data(self._description, sealed.files)
        if self._found.sealed and is_other and not is_named:
            self._found.faults.append(
                Message(
                    "traces or recordings were replaced, and the manifest was written again: the "
                    "log of the survey names other ones"
                )
            )

    def _plan(self) -> Optional[Plan]:
        try:
            plan = Plan(self._description)
        except AnalysisError as error:
            self._found.faults.append(error.message)
            return None
        if self._found.imported is None:
            self._found.planned = len(plan.points)
        else:
            self._note_import(len(plan.points))
        return plan

    def _note_import(self, places: int) -> None:
        found = import_of(self._description)
        self._found.notes.append(
            Message(
                "imported by {software} at {time} from {source} (files: {files}, SHA-256 {sha256})",
                software=str(found.get("software")),
                time=moment_text(str(found.get("time"))),
                source=str(found.get("source")),
                files=str(found.get("files")),
                sha256=str(found.get("sha256")),
            )
        )
        absent = places - int(self._description.get("stored_traces") or 0)
        if absent > 0:
            self._found.notes.append(
                Message("the source has no data at {count} places of its grid", count=absent)
            )

    def _check_trace(self, plan: Optional[Plan], trace: Trace) -> None:
        self._samples.append(Sample.of(trace, row=0))
        if plan is None:
            return
        misfits = plan.misfits(trace) or plan.changed_settings(trace)
        self._found.faults += misfits
        self._found.stored += not misfits

    def _doubt(self) -> None:
        description = whole_description(self._description, self._recovered.found.records)
        self._found.unproven = doubts.unproven_count(description, self._samples)
        self._found.doubts = doubts.survey_doubts(description, self._samples)

    def _check_log(self) -> None:
        log = self._recovered.found
        if not self._found.writer:
            # While somebody writes, the two files may be read at different moments.
            self._found.faults += [
                Message(
                    "{file} is damaged; its entries are whole in the other file of the log: "
                    "resuming the survey, or gpr20 verify --repair, writes it again",
                    file=one,
                )
                for one in log.damaged
            ]
            self._found.faults += [
                Message("entry {number} of the log is damaged in both files", number=number)
                for number in log.lost
            ]
            self._found.notes += [
                Message(
                    "{file} lacks entries at the end of the log, as after a power cut; the next "
                    "change of the survey adds them",
                    file=one,
                )
                for one in log.behind
            ]
        self._found.unconfirmed = tuple(self._description.get(UNCONFIRMED, {}))

    def _check_description(self, readable: int) -> None:
        recorded = self._description
        if self._found.writer:
            return
        self._found.faults += checks.contradictions(recorded)
        if self._indexed and recorded.get("stored_traces") != readable:
            self._found.faults.append(
                Message(
                    "the log records {recorded} stored traces, but {readable} are readable",
                    recorded=recorded.get("stored_traces"),
                    readable=readable,
                )
            )
        if self._found.imported is not None:
            return  # it claims nothing else
        planned = recorded.get("planned_traces", self._found.planned)
        if self._found.planned is not None and planned != self._found.planned:
            self._found.faults.append(
                Message(
                    "the log records {recorded} planned traces, but its parameters give {planned}",
                    recorded=planned,
                    planned=self._found.planned,
                )
            )
        missing = self._found.planned is None or self._found.stored < self._found.planned
        if missing and recorded.get("outcome") == "finished":
            self._found.faults.append(
                Message(
                    "the log records the outcome finished, but planned traces are missing or "
                    "unreadable"
                )
            )
        if missing and _claims_complete(recorded):
            self._found.faults.append(
                Message("the report in the log is complete, but planned traces are missing")
            )


def _claims_complete(recorded: Dict[str, Any]) -> bool:
    """Return whether the report in the log says that no planned trace is missing."""
    report = recorded.get("report")
    return isinstance(report, dict) and report.get("complete") is True
