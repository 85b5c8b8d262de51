"""Going on with a survey that was cut off or ended early: repair, then open."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

from gpr20_survey.errors import (
    SurveyRefusedError,
    TraceRefusedError,
    printable,
    storing,
)
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.recording.recording import Recording
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import ReopenedSurvey, Storage
from gpr20_vna_processing.mid.recorded_traces import RecordedTraces, Types
from gpr20_vna_processing.mid.stored_traces import StoredTraces

MAX_RESUMPTIONS = 100_000


@dataclasses.dataclass(frozen=True)
class RepairedSurvey:
    """A survey whose files are whole again, and its recordings open at their ends."""

    folder: Path
    description: Dict[str, Any]
    recordings: List[Recording]
    stored: StoredTraces
    last: Optional[Trace]
    """The trace that was stored last."""
    repairs: Tuple[str, ...]
    """What was done, for people."""


def reopened_survey(survey: OpenSurvey, repairs: Tuple[str, ...]) -> ReopenedSurvey:
    """Return what is told of a survey that goes on."""
    report = survey.description.get("report")
    return ReopenedSurvey(
        survey_id=survey.survey_id,
        folder=survey.folder,
        metadata_json=json.dumps(survey_metadata.metadata_of(survey.description)),
        report_json="" if report is None else json.dumps(report),
        stored_indices=survey.stored_indices(),
        last=survey.last,
        repairs=repairs,
    )


class Reopening:
    """Repairs the files of one survey.

    A trace is true if its JSON file and a recording, or both recordings, hold the very same
    numbers; what only one of them holds is true unless another contradicts it. Nothing is
    changed before all was read; each step leaves the folder so that the next attempt can
    begin again from the start.
    """

    def __init__(self, folder: Path, description: Dict[str, Any], storage: Storage) -> None:
        """Read and check every file of the survey; nothing is changed.

        Raises:
            SurveyRefusedError: The survey ended complete, or cannot go on.
            StorageFailedError: The disk cannot be read.
        """
        self._folder = folder
        self._description = description
        self._storage = storage
        self._survey_id: str = description["survey_id"]
        self._repairs: List[str] = []
        self._truth: Dict[int, bytes] = {}
        self._last: Optional[Trace] = None
        started_ns = _started_us(description) * utc_time.NS_PER_US
        with storing("the survey", folder, "be read again from"):
            self._files = trace_files.read_all(self._traces, self._survey_id)
            self._recorded = [
                RecordedTraces(one, storage.messages, self._survey_id)
                for one in storage.stored_recordings(folder, description, started_ns)
            ]
        self._types: Types = {}
        for one in self._recorded:
            if one.has_checksums and not one.faults:
                self._types.update(one.types)
        for one in self._recorded:
            one.compare_types(self._types)
        self._decide()
        self._refuse_complete()

    def repair(self, now_us: int) -> RepairedSurvey:
        """Make all files whole and open the recordings at their ends.

        Args:
            now_us: The present moment [us since 1970, UTC].

        Raises:
            StorageFailedError: The disk refused; asking again is safe.
        """
        with storing("the repair", self._folder):
            self._mark_open(utc_time.iso_text(now_us))
            durable_files.ensure_folder(self._traces)
            self._remove_torn()
            self._repair_traces()
            self._repair_recordings()
            stored = self._collect_stored()
            recordings = self._resume_recordings()
        return RepairedSurvey(
            self._folder,
            self._description,
            recordings,
            stored,
            self._last,
            tuple(self._repairs),
        )

    @property
    def _traces(self) -> Path:
        return self._folder / survey_folder.TRACES_FOLDER

    def _decide(self) -> None:
        sources = [(self._files.prints, False)]
        sources += [(one.prints, one.has_checksums) for one in self._recorded]
        for index in sorted({index for prints, _ in sources for index in prints}):
            held = [(prints[index], sure) for prints, sure in sources if index in prints]
            truth = _true_print(held)
            if truth is not None:
                self._truth[index] = truth

    def _refuse_complete(self) -> None:
        whole = (
            self._description.get("outcome") == "finished"
            and (self._folder / manifest.MANIFEST_FILE).is_file()
            and not self._files.damaged
            and all(prints == self._truth for prints in self._all_prints())
            and not any(one.faults for one in self._recorded)
            and len(self._truth)
            == self._description.get("planned_traces", self._description.get("stored_traces"))
        )
        if whole:
            raise SurveyRefusedError(
                f"the survey in {self._folder} is finished and complete with {len(self._truth)} "
                "traces; there is nothing to go on with, begin a new survey"
            )

    def _all_prints(self) -> List[Dict[int, bytes]]:
        return [self._files.prints, *(one.prints for one in self._recorded)]

    def _mark_open(self, now: str) -> None:
        resumed = self._description.get("resumed", [])
        if not isinstance(resumed, list) or len(resumed) >= MAX_RESUMPTIONS:
            raise SurveyRefusedError(f"'resumed' of {self._folder} is no list of times")
        self._description = {
            **self._description,
            "ended": None,
            "outcome": None,
            "reason": "",
            "stored_traces": len(self._truth),
            "resumed": [*resumed, now],
        }
        self._keep_damaged_description()
        # In this order: a manifest beside a survey that has not ended is known to be old.
        path = self._folder / survey_folder.SURVEY_FILE
        durable_files.replace_file(path, survey_metadata.encode(self._description))
        old = self._folder / manifest.MANIFEST_FILE
        if old.is_dir() and not old.is_symlink():
            self._set_aside(old, "this is a folder, no file")
        durable_files.remove_file(old)

    def _keep_damaged_description(self) -> None:
        path = self._folder / survey_folder.SURVEY_FILE
        try:
            survey_metadata.read_description(path)
        except SurveyRefusedError:
            self._repairs.append(
                "wrote survey.json again as it was at the start, from survey.mcap; what it told of "
                "samples that failed is lost"
            )
            if path.exists():
                durable_files.keep_aside(path, self._folder / survey_folder.DAMAGED_FOLDER)

    def _remove_torn(self) -> None:
        removed = sum(durable_files.remove_temporaries(one) for one in (self._folder, self._traces))
        if removed:
            self._repairs.append(f"removed {removed} files that were never finished")

    def _repair_traces(self) -> None:
        for path, reason in self._files.damaged:
            self._set_aside(path, reason)
        for index, name in self._files.names.items():
            if self._files.prints[index] != self._truth.get(index):
                self._set_aside(self._traces / name, "the recordings hold other numbers")
                del self._files.prints[index]
        lost = self._truth.keys() - self._files.prints.keys()
        for recorded in self._recorded if lost else ():
            for trace in recorded.traces():
                if trace.index in lost and trace.fingerprint() == self._truth[trace.index]:
                    self._restore(trace)
                    lost = lost - {trace.index}

    def _set_aside(self, path: Path, reason: str) -> None:
        kept = durable_files.move_aside(path, self._folder / survey_folder.DAMAGED_FOLDER)
        self._repairs.append(f"moved {printable(path.name)} to {kept.parent.name}/: {reason}")

    def _restore(self, trace: Trace) -> None:
        name = survey_folder.trace_file_name(trace)
        durable_files.write_new_file(self._traces / name, trace_json.encode(trace))
        self._files.prints[trace.index] = trace.fingerprint()
        self._files.names[trace.index] = name
        self._repairs.append(f"wrote {name} again from the recordings")

    def _repair_recordings(self) -> None:
        for one in self._recorded:
            wrong = [index for index, own in one.prints.items() if self._truth.get(index) != own]
            if not one.faults and not wrong:
                continue
            reasons = [*one.faults, *(f"trace {index} is another" for index in wrong)]
            one.rebuild(self._truth, self._types)
            self._repairs.append(f"rebuilt {one.name}: {'; '.join(reasons[:3])}")

    def _collect_stored(self) -> StoredTraces:
        stored = StoredTraces()
        for index in self._truth:
            trace = self._read(index)
            stored.add(index, trace.sample_id)
            if self._last is None or _order(trace) > _order(self._last):
                self._last = trace
        return stored

    def _resume_recordings(self) -> List[Recording]:
        recordings: List[Recording] = []
        try:
            for one in self._recorded:
                recordings.append(one.resume())
                self._complete(recordings[-1], one)
        except BaseException:
            for recording in recordings:
                recording.abandon()
            raise
        return recordings

    def _complete(self, recording: Recording, recorded: RecordedTraces) -> None:
        missing = sorted(self._truth.keys() - recorded.prints.keys())
        for index in missing:
            trace = self._read(index)
            recording.begin_chunk()
            time_ns = trace.timestamp_us * utc_time.NS_PER_US
            recording.write(self._storage.messages.trace(trace, time_ns))
            recording.commit()
        if missing:
            self._repairs.append(f"added {len(missing)} traces to {recording.name}")

    def _read(self, index: int) -> Trace:
        path = self._traces / self._files.names[index]
        try:
            return trace_files.read_trace(path, self._survey_id)
        except TraceRefusedError as error:
            raise OSError(f"{path} has changed while it was read: {error}") from error


def _order(trace: Trace) -> Tuple[int, int]:
    return trace.timestamp_us, trace.index


def _true_print(held: List[Tuple[bytes, bool]]) -> Optional[bytes]:
    """Return the fingerprint that is true, of those that the sources hold.

    Args:
        held: Fingerprint and whether its source has checksums.
    """
    counts = Counter(one for one, _ in held)
    (best, count), *others = counts.most_common()
    if count > 1 or not others:
        return best
    return next((one for one, sure in held if sure), None)


def _started_us(description: Dict[str, Any]) -> int:
    try:
        return utc_time.parse_iso(description["started"])
    except (KeyError, TypeError, ValueError) as error:
        raise SurveyRefusedError(f"'started' of survey.json is no time: {error}") from error
