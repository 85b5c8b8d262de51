"""Which traces of a survey are right, by the JSON files and the MCAP, which have checksums."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Collection, Dict, Iterator, List, Mapping, Optional, Set

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ForeignTraceError, StorageFailedError, TraceRefusedError
from gpr20_survey.faults import LOCKED
from gpr20_survey.files import regular_files
from gpr20_survey.folder import manifest, survey_folder, trace_files
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import recorded_log
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace


class RecordedTraces:
    """The traces of a survey's MCAP, whose chunks have checksums; nothing is changed.

    Attributes:
        prints: Fingerprint of the trace of each index.
        log: The checksums of the records of the survey's log.
        foreign: How many whole traces of another survey it holds.
        faults: What is damaged; a trace that is missing is not a fault.
    """

    def __init__(self, path: Path, survey_id: str, on_trace: Callable[[Trace], None]) -> None:
        """Read the whole recording; `on_trace` is called with every whole trace of the survey."""
        self._stored = StoredMcap(path)
        self._places: Dict[int, int] = {}  # of the message of each index
        self.prints: Dict[int, bytes] = {}
        self.log: Set[str] = set()
        self.foreign = 0
        found: List[Message] = []
        for place, message in enumerate(self._stored.messages()):
            record = recorded_log(message)
            if record is not None:
                self.log.add(record.sha256)
            if message.datatype != trace_message.DATATYPE:
                continue
            try:
                trace = trace_message.decode(message.data, message.md5sum)
                self._check_own(trace, survey_id)
            except TraceRefusedError as error:
                self.foreign += isinstance(error, ForeignTraceError)
                reason = error.message
                found.append(Message("{file}: {reason}", file=path.name, reason=reason))
                continue
            self.prints[trace.index] = trace.fingerprint()
            self._places[trace.index] = place
            on_trace(trace)
        self.faults = [*self._stored.faults, *found]

    def messages(self, right: Mapping[int, bytes]) -> Iterator[RecordedMessage]:
        """Yield all messages but the traces that are not right, by their fingerprints."""
        places = {
            place for index, place in self._places.items() if right.get(index) == self.prints[index]
        }
        for place, message in enumerate(self._stored.messages()):
            if place in places or message.datatype != trace_message.DATATYPE:
                yield message

    def traces(self, indices: Collection[int]) -> Iterator[Trace]:
        """Yield the traces of some indices that it holds, in its order."""
        for message in self.messages({index: self.prints[index] for index in indices}):
            if message.datatype == trace_message.DATATYPE:
                yield trace_message.decode(message.data, message.md5sum)

    def _check_own(self, trace: Trace, survey_id: str) -> None:
        if trace.survey_id != survey_id:
            raise ForeignTraceError(
                Message("the trace belongs to survey {survey}", survey=trace.survey_id)
            )
        if trace.index in self.prints:
            raise TraceRefusedError(Message("trace {index} is there twice", index=trace.index))


class StoredTraces:
    """Decides which traces are stored; nothing is changed.

    The first form whose checksum holds is right: the JSON file, then the MCAP; but neither, where
    the manifest has another checksum of the file. The bag is made of the MCAP and is not asked.

    Attributes:
        mcap: The traces of the MCAP.
        files: The JSON files that are right, and those that are not.
        contradicted: Names of the files whose traces the MCAP holds with other numbers.
        truth: Fingerprint of each trace that is stored.
    """

    def __init__(
        self,
        folder: Path,
        survey_id: str,
        sealed: Optional[Manifest],
        is_binding: bool,
        misfits: Callable[[Trace], List[Message]],
    ) -> None:
        """Read the MCAP and every JSON file of a survey.

        Args:
            folder: The survey's folder.
            survey_id: Whose traces there must be.
            sealed: The manifest, if there is a whole one.
            is_binding: Whether a file that differs from it is damaged: it was not reopened since.
            misfits: Returns what of a trace is not as it was planned.
        """
        self._folder = folder
        self._traces = folder / survey_folder.TRACES_FOLDER
        self._sealed = sealed
        self._binding = sealed if is_binding else None
        self._misfits: Dict[bytes, List[Message]] = {}  # by the fingerprint of the trace

        def compare(trace: Trace) -> None:
            found = misfits(trace)
            if found:
                self._misfits[trace.fingerprint()] = found

        self.mcap = RecordedTraces(folder / survey_folder.MCAP_FILE, survey_id, compare)
        self.files = trace_files.read_all(self._traces, survey_id, on_trace=compare)
        self.contradicted: List[str] = []
        self.truth: Dict[int, bytes] = {}
        self._decide()

    @property
    def misfits(self) -> List[Message]:
        """What of the stored traces is not as it was planned."""
        prints = (self.truth[index] for index in sorted(self.truth))
        return [found for one in prints for found in self._misfits.get(one, [])]

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
            and not binding.matches(name, regular_files.sum_if_readable(self._folder / name))
        ]

    def _decide(self) -> None:
        for index, file in list(self.files.files.items()):
            if self._is_refuted(file):
                del self.files.files[index]
                self.files.damaged.append((self._traces / file.name, _differs(file.name)))
                continue
            self.truth[index] = file.fingerprint
            recorded = self.mcap.prints.get(index)
            if not self._is_listed(file) and recorded not in (None, file.fingerprint):
                reason = Message(
                    "{file} and survey.mcap hold different numbers with right checksums",
                    file=file.name,
                )
                self._contradict(file.name, reason)
        lost = self.mcap.prints.keys() - self.truth.keys()
        self.truth.update({index: self.mcap.prints[index] for index in lost})
        # The manifest may have others than those that the MCAP alone holds.
        for trace in self.mcap.traces(lost) if lost and self._sealed is not None else ():
            file = TraceFile.of(trace, trace_files.encode(trace))
            if self._is_refuted(file):
                del self.truth[trace.index]
                self._contradict(file.name, _differs(file.name))

    def _contradict(self, name: str, reason: Message) -> None:
        self.contradicted.append(name)
        # As a fault of the recording, which is therefore kept.
        self.mcap.faults.append(reason)

    def _is_listed(self, file: TraceFile) -> bool:
        name = manifest.trace_name(file.name)
        return self._sealed is not None and self._sealed.matches(name, file.sum)

    def _is_refuted(self, file: TraceFile) -> bool:
        """Return whether the manifest, also one from before a reopening, has another trace."""
        if self._sealed is None or self._is_listed(file):
            return False
        return self._binding is not None or manifest.trace_name(file.name) in self._sealed.files


def _differs(name: str) -> Message:
    return Message("{file} differs from the manifest", file=name)


def read_again(path: Path, survey_id: str) -> Trace:
    """Return the trace of a file that was whole before; StorageFailedError: it is not any more."""
    try:
        return trace_files.read_trace(path, survey_id)
    except TraceRefusedError as error:
        raise StorageFailedError(
            Message(
                "{path} changed while it was read: {reason}; try again",
                path=printable(path),
                reason=error.message,
            ).reporting_only(LOCKED)
        ) from error
