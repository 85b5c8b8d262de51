"""Which traces of a survey are right, by the JSON files and the MCAP, which have checksums."""

from __future__ import annotations

from pathlib import Path
from typing import AbstractSet, Callable, Dict, List, Mapping, Optional, Set

from gpr20_common.message import Message
from gpr20_survey.errors import ForeignTraceError, TraceRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest, survey_folder, trace_files
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import recorded_log, recorded_trace
from gpr20_survey.trace import trace_json
from gpr20_survey.trace.trace import Trace

Misfits = Callable[[Trace], List[Message]]
"""Returns what of a trace is not as it was planned."""


class RecordedTraces:
    """The traces of a survey's MCAP, whose chunks have checksums; nothing is changed."""

    def __init__(self, path: Path, survey_id: str, misfits: Misfits) -> None:
        """Read the whole recording.

        Args:
            path: The MCAP.
            survey_id: Whose traces there must be.
            misfits: Compares a trace with the plan.

        Raises:
            OSError: The file cannot be read.
        """
        self.stored = StoredMcap(path)
        self.prints: Dict[int, bytes] = {}
        """Fingerprint of the trace of each index."""
        self.wrong: Dict[int, List[Message]] = {}
        """What of each trace is not as it was planned."""
        self.log: Set[str] = set()
        """The checksums of the records of the survey's log."""
        self.foreign = 0
        """How many whole traces of another survey it holds."""
        self._survey_id = survey_id
        self._misfits = misfits
        self._places: Dict[int, int] = {}  # of the message of each index
        found: List[Message] = []
        for place, message in enumerate(self.stored.messages()):
            record = recorded_log(message)
            if record is not None:
                self.log.add(record.sha256)
            try:
                self._note(place, message)
            except TraceRefusedError as error:
                self.foreign += isinstance(error, ForeignTraceError)
                found.append(
                    Message(
                        "{file} holds a damaged trace: {reason}",
                        file=path.name,
                        reason=error.message,
                    )
                )
        self.faults = [*self.stored.faults, *found]
        """What is damaged; a trace that is missing is not a fault."""

    def places(self, truth: Mapping[int, bytes]) -> Set[int]:
        """Return which messages of the recording are traces that are right.

        Args:
            truth: Fingerprint of each trace that is stored.
        """
        return {
            place for index, place in self._places.items() if truth.get(index) == self.prints[index]
        }

    def _note(self, place: int, message: RecordedMessage) -> None:
        trace = recorded_trace(message)
        if trace is None:
            return
        if trace.survey_id != self._survey_id:
            raise ForeignTraceError(
                Message(
                    "{trace} belongs to survey {survey}", trace=trace.label, survey=trace.survey_id
                )
            )
        if trace.index in self.prints:
            raise TraceRefusedError(Message("trace {index} is there twice", index=trace.index))
        self.prints[trace.index] = trace.fingerprint()
        self._places[trace.index] = place
        misfits = self._misfits(trace)
        if misfits:
            self.wrong[trace.index] = misfits


class StoredTraces:
    """Decides which traces are stored; nothing is changed.

    The first form whose checksum holds is right: the JSON file, then the MCAP; but neither, where
    the manifest has another checksum of the file. The bag is made of the MCAP and is not asked.
    """

    def __init__(
        self,
        folder: Path,
        mcap: RecordedTraces,
        survey_id: str,
        sealed: Optional[Manifest],
        is_binding: bool,
        misfits: Misfits,
    ) -> None:
        """Read every JSON file.

        Args:
            folder: The survey's folder.
            mcap: The traces of its MCAP.
            survey_id: Whose traces there must be.
            sealed: The manifest, if there is a whole one.
            is_binding: Whether a file that differs from it is damaged: after a reopening files
                change.
            misfits: Compares a trace with the plan.

        Raises:
            OSError: The disk cannot be read.
        """
        self._folder = folder
        self._sealed = sealed
        self._binding = sealed if is_binding else None
        self._misfits = misfits
        self.mcap = mcap
        self._wrong: Dict[int, List[Message]] = {}  # misfits of each JSON file
        traces = folder / survey_folder.TRACES_FOLDER
        self.files = trace_files.read_all(traces, survey_id, on_trace=self._compare)
        self.contradicted: List[str] = []
        """Names of the files whose traces the MCAP holds with other numbers."""
        self.truth: Dict[int, bytes] = {}
        """Fingerprint of each trace that is stored."""
        self._decide(traces)
        self.misfits = self._misfits_of_truth()
        """What of the stored traces is not as it was planned."""

    @property
    def foreign(self) -> int:
        """How many whole traces of another survey there are."""
        return self.files.foreign + self.mcap.foreign

    def intact(self) -> bool:
        """Return whether every file is as it was when the survey was closed."""
        return (
            self._binding is not None
            and not self.files.damaged
            and self.files.prints == self.truth == self.mcap.prints
            and not self.mcap.faults
            and not self.changes()
        )

    def changes(self) -> List[Message]:
        """Return how files other than traces differ from a binding manifest."""
        binding = self._binding
        if binding is None:
            return []
        unreadable = {name for name, one in binding.files.items() if one is None}
        names = {*binding.files, *manifest.file_names(self._folder)} - unreadable
        return [
            _differs(name)
            for name in sorted(names)
            if not name.startswith((manifest.trace_name(""), f"{survey_folder.DAMAGED_FOLDER}/"))
            and not binding.matches(name, file_sums.sum_if_readable(self._folder / name))
        ]

    def _compare(self, trace: Trace) -> None:
        misfits = self._misfits(trace)
        if misfits:
            self._wrong[trace.index] = misfits

    def _decide(self, traces: Path) -> None:
        for index, file in list(self.files.files.items()):
            if self._is_refuted(file):
                self._refuse(traces, index, _differs(file.name))
                continue
            self.truth[index] = file.fingerprint
            recorded = self.mcap.prints.get(index)
            if not self._is_listed(file) and recorded not in (None, file.fingerprint):
                self._contradict(
                    file.name,
                    Message(
                        "{file} and survey.mcap hold different numbers with right checksums",
                        file=file.name,
                    ),
                )
        lost = self.mcap.prints.keys() - self.truth.keys()
        self.truth.update({index: self.mcap.prints[index] for index in lost})
        if lost and self._sealed is not None:
            self._refuse_recorded(lost)

    def _refuse_recorded(self, indexes: AbstractSet[int]) -> None:
        """Refuse the traces that the MCAP alone holds, but of which the manifest has other ones."""
        places = self.mcap.places({index: self.truth[index] for index in indexes})
        for place, message in enumerate(self.mcap.stored.messages()):
            trace = recorded_trace(message) if place in places else None
            if trace is None:
                continue
            file = TraceFile.of(trace, trace_json.encode(trace))
            if self._is_refuted(file):
                del self.truth[trace.index]
                self._contradict(file.name, _differs(file.name))

    def _contradict(self, name: str, reason: Message) -> None:
        self.contradicted.append(name)
        # As a fault of the recording, which is therefore kept.
        self.mcap.faults.append(reason)

    def _misfits_of_truth(self) -> List[Message]:
        found: List[Message] = []
        for index in sorted(self.truth):
            wrong = self._wrong if index in self.files.files else self.mcap.wrong
            found += wrong.get(index, [])
        return found

    def _is_listed(self, file: TraceFile) -> bool:
        name = manifest.trace_name(file.name)
        return self._sealed is not None and self._sealed.matches(name, file.sum)

    def _is_refuted(self, file: TraceFile) -> bool:
        """Return whether the manifest, also one from before a reopening, has another trace."""
        if self._sealed is None or self._is_listed(file):
            return False
        return self._binding is not None or manifest.trace_name(file.name) in self._sealed.files

    def _refuse(self, traces: Path, index: int, reason: Message) -> None:
        self.files.damaged.append((traces / self.files.files.pop(index).name, reason))


def _differs(name: str) -> Message:
    return Message("{file} differs from the manifest", file=name)
