"""Checks everything that can be checked of a survey's folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.low import recorded_messages
from gpr20_analysis.mid import manifest_check, recorded_traces
from gpr20_analysis.mid.coverage import Plan
from gpr20_analysis.mid.survey_source import Progress, silent
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.stored_recording import StoredRecording

FILES = (
    survey_folder.SURVEY_FILE,
    survey_folder.TRACES_FOLDER,
    survey_folder.BAG_FILE,
    survey_folder.MCAP_FILE,
)
COMPLETE, INCOMPLETE, DAMAGED = 0, 1, 2


@dataclass
class Verification:
    """What was found in a survey's folder."""

    faults: List[str] = field(default_factory=list)
    """What is damaged or contradictory, one sentence each."""
    notes: List[str] = field(default_factory=list)
    """What else should be known."""
    planned: Optional[int] = None
    """Number of planned samples; None if that cannot be told."""
    stored: int = 0
    """Number of planned samples that are stored and readable."""
    closed: bool = False
    """Whether the survey was closed, not cut off or interrupted."""

    @property
    def status(self) -> int:
        """0 complete and intact, 1 intact but not complete, 2 damaged or contradictory."""
        if self.faults:
            return DAMAGED
        whole = self.closed and self.planned is not None and self.stored == self.planned
        return COMPLETE if whole else INCOMPLETE

    @property
    def verdict(self) -> str:
        """The result in one sentence."""
        of = "an unknown number of" if self.planned is None else f"{self.planned}"
        counted = f"{self.stored} of {of} planned traces are stored and readable"
        if self.faults:
            return f"DAMAGED or contradictory ({len(self.faults)} faults): {counted}"
        if self.status == COMPLETE:
            return f"complete and intact: all {self.planned} planned traces are stored and readable"
        ending = "" if self.closed else ", and the survey was not closed"
        return f"INCOMPLETE, but intact: {counted}{ending}"


def verify(folder: Path, progress: Progress = silent) -> Verification:
    """Check a survey's folder; nothing in it is changed.

    Args:
        folder: The folder of one survey.
        progress: Shows how far each pass over its traces has come.

    Raises:
        AnalysisError: The folder is none of a survey.
        OSError: The disk cannot be read.
    """
    if not any((folder / name).exists() for name in FILES):
        raise AnalysisError(
            f"{folder} is no folder of a survey; none of {', '.join(FILES)} is in it"
        )
    try:
        description = survey_metadata.read_description(folder / survey_folder.SURVEY_FILE)
        survey_folder.check_survey_id(description["survey_id"])
    except SurveyRefusedError as error:
        return Verification(faults=[str(error)])
    return _Verifier(folder, description, progress).run()


class _Verifier:
    def __init__(self, folder: Path, description: Dict[str, Any], progress: Progress) -> None:
        self._folder = folder
        self._progress = progress
        self._description = description
        self._survey_id: str = description["survey_id"]
        self._indexed = description.get("ended") is not None  # the recordings have their index
        closed = self._indexed and description.get("outcome") != INTERRUPTED
        self._found = Verification(closed=closed)

    def run(self) -> Verification:
        self._check_manifest()
        files = trace_files.read_all(
            self._traces, self._survey_id, lambda paths: iter(self._progress(paths, len(paths)))
        )
        for path, reason in files.damaged:
            self._fault(f"{path.name} is no whole trace: {reason}")
        plan = self._plan()
        for index, name in self._progress(sorted(files.names.items()), len(files.names)):
            self._check_trace(plan, index, name)
        self._check_recordings(files.prints)
        self._check_words(len(files.prints))
        return self._found

    @property
    def _traces(self) -> Path:
        return self._folder / survey_folder.TRACES_FOLDER

    def _fault(self, text: str) -> None:
        self._found.faults.append(text)

    def _check_manifest(self) -> None:
        if self._found.closed:
            self._found.faults += manifest_check.check_files(self._folder, self._survey_id)
        elif (self._folder / manifest.MANIFEST_FILE).exists():
            self._found.notes.append("the manifest is from before the survey was reopened")
        else:
            self._found.notes.append("the survey was not closed, so there is no manifest")
        if (self._folder / survey_folder.DAMAGED_FOLDER).is_dir():
            self._found.notes.append(
                f"{survey_folder.DAMAGED_FOLDER}/ holds files that were damaged and were replaced"
            )

    def _plan(self) -> Optional[Plan]:
        try:
            plan = Plan(self._description)
        except AnalysisError as error:
            self._fault(str(error))
            return None
        self._found.planned = len(plan.points)
        return plan

    def _check_trace(self, plan: Optional[Plan], index: int, name: str) -> None:
        if plan is None:
            return
        try:
            trace = trace_files.read_trace(self._traces / name, self._survey_id)
        except (TraceRefusedError, OSError) as error:
            self._fault(f"{name} changed while it was read: {error}")
            return
        misplaced = plan.misplaced(trace)
        self._found.faults += misplaced
        self._found.stored += not misplaced

    def _check_recordings(self, stored: Dict[int, bytes]) -> None:
        for name in (survey_folder.BAG_FILE, survey_folder.MCAP_FILE):
            before = len(self._found.faults)
            recorded = recorded_traces.fingerprints(
                name,
                iter(self._progress(self._recorded(name), len(stored))),
                self._survey_id,
                self._found.faults,
            )
            if len(self._found.faults) == before:
                self._check_missing(name, sorted(stored.keys() - recorded.keys()))
            self._found.faults += recorded_traces.contradictions(name, recorded, stored)

    def _check_missing(self, name: str, missing: List[int]) -> None:
        # The JSON file comes first: a crash may fall between it and a recording, but the
        # next trace is not stored before this one is in both.
        if len(missing) == 1 and not self._indexed:
            self._found.notes.append(
                f"trace {missing[0]} is not in {name} yet; it is put there when the survey goes on"
            )
            return
        for index in missing:
            self._fault(f"trace {index} has a JSON file but is not in {name}")

    def _recorded(self, name: str) -> Iterator[Dict[str, Any]]:
        path = self._folder / name
        if not self._indexed:
            return recorded_messages.unfinished_traces(_unfinished(path))
        if name == survey_folder.BAG_FILE:
            return recorded_messages.bag_traces(path)
        return recorded_messages.mcap_traces(path)

    def _check_words(self, readable: int) -> None:
        told = self._description
        if self._indexed and told.get("stored_traces") != readable:
            self._fault(
                f"survey.json tells of {told.get('stored_traces')} stored traces, but {readable} "
                "are readable"
            )
        planned = told.get("planned_traces", self._found.planned)
        if self._found.planned is not None and planned != self._found.planned:
            self._fault(
                f"survey.json tells of {planned} planned traces, but its parameters plan "
                f"{self._found.planned}"
            )
        missing = self._found.planned is None or self._found.stored < self._found.planned
        if missing and told.get("outcome") == "finished":
            self._fault("survey.json says finished, but not every planned trace is readable")
        if missing and _claims_complete(told.get("report")):
            self._fault("the report in survey.json says complete, but traces are missing")


def _claims_complete(report: Any) -> bool:
    verdict = report.get("verdict") if isinstance(report, dict) else None
    return isinstance(verdict, str) and verdict.startswith("complete")


def _unfinished(path: Path) -> StoredRecording:
    if path.name == survey_folder.BAG_FILE:
        return StoredBag(path)
    return StoredMcap(path)
