"""Verification of a survey's folder: files, values, positions, recordings."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Iterator, List, Mapping, Optional, Union

from gpr20_analysis import errors
from gpr20_analysis.dataset import SIMULATED, mapping_of, objects_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read import checks, doubts
from gpr20_analysis.read.sources import whole_description
from gpr20_analysis.read.traces import Sample, unknown_plan
from gpr20_analysis.read.verdict import Verification
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.faults import MANIFEST_DAMAGED
from gpr20_survey.files.durable_files import writer_of
from gpr20_survey.folder import survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import UNCONFIRMED, Kind
from gpr20_survey.folder.recovery import RecoveredSurvey, recover
from gpr20_survey.plan.recorded_plan import PlanFit, import_sentence, is_imported
from gpr20_survey.plan.robot_description import is_simulated_identity
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import moment_text

FILES = (
    survey_folder.SURVEY_FILE,
    *survey_folder.LOG_FILES,
    survey_folder.TRACES_FOLDER,
    survey_folder.BAG_FILE,
    survey_folder.MCAP_FILE,
)
UNKNOWN_GROUND = Message("it is not known whether the data are SIMULATED")
REMEDY = Message(
    "gpr20 verify --repair compares everything else and, if all of it agrees, writes it again"
)


def check_survey_folder(folder: Path) -> None:
    """Check that a folder contains any part of a survey.

    Raises:
        AnalysisError: It does not.
    """
    if not folder.exists():
        raise AnalysisError(errors.not_there(folder), fault=errors.INPUT)
    if not any(os.path.lexists(str(folder / name)) for name in FILES):
        raise AnalysisError(
            Message(
                "{folder} is not the folder of a survey: it contains none of {names}",
                folder=folder,
                names=", ".join(FILES),
            ),
            fault=errors.INPUT,
        )


def verify_survey(
    folder: Union[str, Path],
    progress: Progress = no_progress,
    repairing: bool = False,
) -> Verification:
    """Check a survey's folder; nothing in it is changed.

    Args:
        folder: The folder of one survey.
        progress: Shows the progress of each pass over its traces.
        repairing: Check all but log and manifest, which the caller, who holds the folder's lock,
            writes again.

    Raises:
        AnalysisError: It is not the folder of a survey.
        OSError: The disk cannot be read.
    """
    folder = Path(folder).expanduser()
    check_survey_folder(folder)
    writer = "" if repairing else writer_of(folder) or ""
    try:
        survey_folder.check_no_links(folder)
    except SurveyRefusedError as error:
        return Verification(faults=[error.message])
    try:
        recovered = recover(folder, asking_manifest=True)
    except SurveyRefusedError as error:
        return _of_traces(folder / survey_folder.TRACES_FOLDER, error.message, progress)
    verifier = _Verifier(folder, recovered, writer)
    if not repairing:
        if not writer:
            verifier.check_manifest()
        verifier.check_log()
    verifier.check_data(progress)
    return verifier.found


def _of_traces(folder: Path, refusal: Message, progress: Progress) -> Verification:
    """Return what the files of traces say where nothing else of a survey can be read."""
    found = Verification(faults=[refusal], notes=[UNKNOWN_GROUND])
    paths = sorted(folder.glob("*.json"))
    for path in progress(paths, len(paths)):
        try:
            trace_files.read_trace(path)
            found.stored += 1
        except (TraceRefusedError, OSError) as error:
            reason = os_reason(error) if isinstance(error, OSError) else error.message
            found.faults.append(_not_intact(path, reason).with_fault(refusal.fault))
    return found


def _not_intact(path: Path, reason: Message) -> Message:
    return Message("{file} is not an intact trace: {reason}", file=path.name, reason=reason)


class _Verifier:
    """Checks a survey, part by part.

    Attributes:
        found: What was found until now.
    """

    def __init__(self, folder: Path, recovered: RecoveredSurvey, writer: str) -> None:
        self._folder = folder
        self._recovered = recovered
        self._description = described = recovered.description
        self._has_ended = described.get("ended") is not None
        is_interrupted = described.get("outcome") == survey_metadata.INTERRUPTED
        self.found = Verification(
            closed=self._has_ended and not is_interrupted,
            writer=writer,
            imported=import_sentence(described) if is_imported(described) else None,
        )
        self._samples: List[Sample] = []

    def check_manifest(self) -> None:
        """Check the files of the survey by its manifest, and the manifest."""
        found, sealed, damage = self.found, self._recovered.manifest, None
        found.sealed = checks.is_sealed(self._recovered)
        found.faults += checks.manifest_differences(self._folder, self._recovered)
        if self._recovered.manifest_damage is not None:
            damage = Message(
                "manifest.json is damaged: {reason}; {remedy}",
                reason=self._recovered.manifest_damage,
                remedy=REMEDY,
            )
        elif sealed is None and found.closed:
            damage = Message(
                "manifest.json is missing, so changes to files cannot be detected: it was "
                "removed, or the survey was cut off while it was closed; {remedy}",
                remedy=REMEDY,
            )
        elif sealed is not None:
            self._note_later(sealed.log.number)
            is_named = checks.DATA in self._description.get(UNCONFIRMED, {})
            is_other = checks.has_other_data(self._description, sealed.files)
            if found.sealed and is_other and not is_named:
                found.faults.append(
                    Message(
                        "traces or recordings were replaced, and the manifest was written again: "
                        "the log of the survey names other ones"
                    )
                )
        if damage is not None:
            found.faults.append(damage.reporting_only(MANIFEST_DAMAGED))
        if (self._folder / survey_folder.DAMAGED_FOLDER).is_dir():
            found.notes.append(
                Message(
                    "{folder}/ contains damaged files that were replaced",
                    folder=survey_folder.DAMAGED_FOLDER,
                )
            )

    def _note_later(self, sealed: int) -> None:
        """Note what the log says of the manifest, which it had after this entry."""
        for one in self._recovered.found.records:
            if one.kind == Kind.RESUME.value and one.number > sealed:
                self.found.notes.append(
                    Message(
                        "the manifest is from before the survey was reopened at {time}",
                        time=moment_text(one.time),
                    )
                )
            elif one.kind == Kind.SEAL.value:
                self.found.notes.append(
                    Message(
                        "the manifest was written again at {time}: {reason}; what was changed "
                        "before is not covered",
                        time=moment_text(one.time),
                        reason=str(one.values.get("reason")),
                    )
                )

    def check_log(self) -> None:
        """Check the two files of the log."""
        log, found = self._recovered.found, self.found
        found.unconfirmed = tuple(self._description.get(UNCONFIRMED, {}))
        if found.writer:
            return  # the two files may have been read at different moments
        found.faults += [
            Message(
                "{file} is damaged; its entries are whole in the other file of the log: resuming "
                "the survey, or gpr20 verify --repair, writes it again",
                file=one,
            )
            for one in log.damaged
        ]
        found.faults += [
            Message("entry {number} of the log is damaged in both files", number=number)
            for number in log.lost
        ]
        found.notes += [
            Message(
                "{file} lacks entries at the end of the log, as after a power cut; the next "
                "change of the survey adds them",
                file=one,
            )
            for one in log.behind
        ]

    def check_data(self, progress: Progress) -> None:
        """Check traces, recordings, and what the log says of them."""
        found, plan = self.found, self._plan()
        files = trace_files.read_all(
            self._folder / survey_folder.TRACES_FOLDER,
            self._recovered.survey_id,
            lambda paths: iter(progress(paths, len(paths))),
            lambda trace: self._check_trace(plan, trace),
        )
        found.faults += [_not_intact(path, reason) for path, reason in files.damaged]
        records = self._recovered.found.records
        description = whole_description(self._description, records)
        found.unproven = doubts.unproven_count(description, self._samples)
        found.doubts = doubts.survey_doubts(description, self._samples)
        checks.check_recording(self._folder, self._recovered, files.prints, progress, found)
        if not found.writer:
            has_bag = self._has_ended and found.imported is None
            checks.check_bag(self._folder, records, has_bag, found)
            found.faults += _contradictions(self._description)
            self._check_claims(len(files.prints))

    def _plan(self) -> Optional[PlanFit]:
        try:
            plan = PlanFit(self._description)
        except InvalidValueError as error:
            self.found.faults.append(unknown_plan(error.message))
            if SIMULATED not in self._description:
                self.found.notes.append(UNKNOWN_GROUND)
            return None
        if self.found.imported is None:
            self.found.planned = len(plan.points)
            return plan
        absent = len(plan.points) - int(self._description.get("stored_traces") or 0)
        if absent > 0:
            self.found.notes.append(
                Message("the source has no data at {count} places of its grid", count=absent)
            )
        return plan

    def _check_trace(self, plan: Optional[PlanFit], trace: Trace) -> None:
        self._samples.append(Sample.of(trace, row=0))
        misfits = (plan.misfits(trace) or plan.changed_settings(trace)) if plan else []
        self.found.faults += misfits
        self.found.stored += not misfits

    def _check_claims(self, readable: int) -> None:
        """Compare what the log says of the survey with what is there."""
        log, planned = self._description, self.found.planned
        if self._has_ended and log.get("stored_traces") != readable:
            self.found.faults.append(
                Message(
                    "the log records {recorded} stored traces, but there are {present}",
                    recorded=log.get("stored_traces"),
                    present=readable,
                )
            )
        if planned is not None and log.get("planned_traces", planned) != planned:
            self.found.faults.append(
                Message(
                    "the log records {recorded} planned traces, but there are {present}",
                    recorded=log.get("planned_traces"),
                    present=planned,
                )
            )
        is_missing = planned is None or self.found.stored < planned
        is_complete = mapping_of(log, "report").get("complete") is True
        says_complete = log.get("outcome") == "finished" or is_complete
        if self.found.imported is None and is_missing and says_complete:
            self.found.faults.append(
                Message(
                    "the log says that the survey is complete, but planned traces are missing or "
                    "unreadable"
                )
            )


def _contradictions(description: Mapping[str, Any]) -> Iterator[Message]:
    """Yield where the entry `simulated` contradicts what measured the survey."""
    simulated = description.get("simulated")
    if not isinstance(simulated, bool):
        return
    identity = mapping_of(description, "instrument").get("identity")
    if isinstance(identity, str) and is_simulated_identity(identity) is not simulated:
        yield Message(
            "the survey says simulated: {simulated}, but the analyzer's identity is {identity}",
            simulated=str(simulated).lower(),
            identity=identity,
        )
    for node in objects_of(description, "nodes"):
        if node.get("simulated") is not simulated:
            yield Message(
                "the survey says simulated: {simulated}, but node {node} says otherwise",
                simulated=str(simulated).lower(),
                node=str(node.get("name")),
            )
