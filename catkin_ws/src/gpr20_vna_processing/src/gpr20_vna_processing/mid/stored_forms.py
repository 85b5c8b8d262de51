"""The three forms of a survey's traces on the disk, and which traces are true."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path
from typing import Callable, Dict, List, Optional, Set, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import ForeignTraceError, TraceRefusedError
from gpr20_survey.folder import manifest, survey_folder, trace_files
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.stored_recording import StoredRecording
from gpr20_survey.recording.survey_topics import recorded_trace
from gpr20_survey.trace.trace import Trace

# Name, checksum and definition of a message type.
Type = Tuple[str, str, str]


@dataclasses.dataclass
class RecordedTraces:
    """What was found in a recording."""

    stored: StoredRecording
    prints: Dict[int, bytes] = dataclasses.field(default_factory=dict)
    """Fingerprint of the trace of each index."""
    types: Dict[str, Set[Type]] = dataclasses.field(default_factory=dict)
    """Types of the messages of each topic."""
    faults: List[Message] = dataclasses.field(default_factory=list)
    foreign: int = 0
    """How many whole traces of another survey it holds."""

    @property
    def name(self) -> str:
        """File name."""
        return self.stored.path.name

    def read(self, trace_of: Callable[[RecordedMessage], Optional[Trace]]) -> None:
        """Read the whole recording.

        Raises:
            OSError: The file cannot be read.
        """
        for message in self.stored.messages():
            own = (message.datatype, message.md5sum, message.definition)
            self.types.setdefault(message.topic, set()).add(own)
            try:
                trace = trace_of(message)
            except TraceRefusedError as error:
                self.foreign += isinstance(error, ForeignTraceError)
                self.faults.append(
                    Message(
                        "{file} holds a damaged trace: {reason}",
                        file=self.name,
                        reason=error.message,
                    )
                )
                continue
            if trace is not None and trace.index in self.prints:
                self.faults.append(
                    Message("{file} holds trace {index} twice", file=self.name, index=trace.index)
                )
            elif trace is not None:
                self.prints[trace.index] = trace.fingerprint()
        self.faults = [*self.stored.faults, *self.faults]

    def compare_types(self, certain: Dict[str, Type]) -> None:
        """Add a fault for every topic whose type is not the certain one."""
        for topic, types in self.types.items():
            if topic in certain and types != {certain[topic]}:
                self.faults.append(
                    Message("{file} holds a damaged message type", file=self.name, details=topic)
                )


class StoredForms:
    """Reads all three forms of every trace and decides; nothing is changed.

    The true traces are the union of what the forms hold. Where they contradict each other, two
    of them decide, else the one that a checksum vouches for: the MCAP has its own, the other
    files have those of the manifest. A trace on which nothing decides counts as not stored.
    What a reopening that was killed has put aside contradicts as well.
    """

    def __init__(self, folder: Path, survey_id: str) -> None:
        """Read everything.

        Raises:
            OSError: The disk cannot be read.
        """
        self._folder = folder
        self._survey_id = survey_id
        self.files = trace_files.read_all(folder / survey_folder.TRACES_FOLDER, survey_id)
        self.stored_bag = StoredBag(folder / survey_folder.BAG_FILE)
        self.bag = RecordedTraces(self.stored_bag)
        self.mcap = RecordedTraces(StoredMcap(folder / survey_folder.MCAP_FILE))
        for one in self.recordings:
            one.read(self.trace_of)
        self._types: Dict[str, Type] = {}
        if not self.mcap.faults:
            self._types = {
                topic: next(iter(types))
                for topic, types in self.mcap.types.items()
                if len(types) == 1
            }
        self.bag.compare_types(self._types)
        self._sums = manifest.read_sums(folder)
        self.truth = self._decide()
        """Fingerprint of each trace that is true."""

    @property
    def recordings(self) -> Tuple[RecordedTraces, RecordedTraces]:
        """Both recordings."""
        return self.bag, self.mcap

    @property
    def foreign(self) -> int:
        """How many whole traces of another survey there are."""
        return self.files.foreign + sum(one.foreign for one in self.recordings)

    def intact(self) -> bool:
        """Return whether every form holds every true trace, unchanged since the end."""
        return (
            not self.files.damaged
            and self.files.prints == self.truth
            and all(one.prints == self.truth and not one.faults for one in self.recordings)
            and all(map(self._unchanged, manifest.DATA_FILES))
            and all(map(self._unchanged, map(_manifest_name, self.files.names.values())))
        )

    def faults_of(self, recorded: RecordedTraces) -> List[Message]:
        """Return what is wrong in a recording; a trace that is missing is not a fault."""
        wrong = [index for index, own in recorded.prints.items() if self.truth.get(index) != own]
        return [
            *recorded.faults,
            *(Message("trace {index} has other numbers", index=index) for index in wrong),
        ]

    def bag_is_right(self) -> bool:
        """Return whether all that is whole in the bag can stay: the MCAP vouches for its types."""
        return not self.faults_of(self.bag) and self.bag.types.keys() <= self._types.keys()

    def md5sums(self) -> Dict[str, Set[str]]:
        """Return the checksums of the types of each topic, the certain ones where there are any."""
        found: Dict[str, Set[str]] = {}
        for recorded in self.recordings:
            for topic, types in recorded.types.items():
                certain = {self._types[topic]} if topic in self._types else types
                found.setdefault(topic, set()).update(md5sum for _name, md5sum, _text in certain)
        return found

    def trace_of(self, message: RecordedMessage) -> Optional[Trace]:
        """Return the trace of a recorded message, or None if it is no trace.

        Raises:
            TraceRefusedError: It cannot be read, or is of another survey.
        """
        trace = recorded_trace(message)
        if trace is not None and trace.survey_id != self._survey_id:
            raise ForeignTraceError(
                Message(
                    "{trace} belongs to survey {survey}",
                    trace=trace.label,
                    survey=trace.survey_id,
                )
            )
        return trace

    def true_trace(self, message: RecordedMessage) -> Optional[Trace]:
        """Return the trace of a recorded message if it is a true one."""
        try:
            trace = self.trace_of(message)
        except TraceRefusedError:
            return None  # named among the faults
        if trace is None or self.truth.get(trace.index) != trace.fingerprint():
            return None
        return trace

    def with_certain_type(self, message: RecordedMessage) -> RecordedMessage:
        """Return a message with the type that its topic has for certain, if that is known."""
        datatype, md5sum, definition = self._types.get(
            message.topic, (message.datatype, message.md5sum, message.definition)
        )
        return dataclasses.replace(message, datatype=datatype, md5sum=md5sum, definition=definition)

    def _decide(self) -> Dict[int, bytes]:
        sources = [self.files.prints, self.bag.prints, self.mcap.prints]
        put_aside = trace_files.prints_put_aside(
            self._folder / survey_folder.DAMAGED_FOLDER, self._survey_id
        )
        truth: Dict[int, bytes] = {}
        for index in sorted({index for prints in sources for index in prints}):
            held = Counter(prints[index] for prints in sources if index in prints)
            (best, count), *others = held.most_common()
            contradicted = others or put_aside.get(index, set()) - {best}
            decided = best if count > 1 or not contradicted else self._vouched(index)
            if decided is not None:
                truth[index] = decided
        return truth

    def _vouched(self, index: int) -> Optional[bytes]:
        if index in self.mcap.prints:
            return self.mcap.prints[index]
        file = self.files.files.get(index)
        if file is not None and self._unchanged(_manifest_name(file.name)):
            return file.fingerprint
        return self.bag.prints.get(index) if self._unchanged(self.bag.name) else None

    def _unchanged(self, name: str) -> bool:
        return manifest.is_unchanged(self._folder, name, self._sums)


def _manifest_name(name: str) -> str:
    return f"{survey_folder.TRACES_FOLDER}/{name}"
