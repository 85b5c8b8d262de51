"""The three forms of a survey's traces on the disk, and which traces are true."""

from __future__ import annotations

import dataclasses
from collections import Counter
from pathlib import Path
from typing import Dict, List, Optional, Set, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import ForeignTraceError, TraceRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.files.file_sums import FileSum
from gpr20_survey.folder import manifest, sealing, survey_folder, trace_files
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.trace_files import OnTrace
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import recorded_trace
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.recorded_traces import RecordedTraces, Type

_NOT_LISTED = FileSum("", 0)


class StoredForms:
    """Reads all three forms of every trace and decides; nothing is changed.

    The true traces are the union of what the forms hold. Where they contradict each other, a
    file that is as in the manifest decides, else two of them, else the MCAP, whose chunks have
    checksums. A trace on which nothing decides counts as not stored. What a reopening that was
    killed has put aside contradicts as well. A file that differs from the manifest is damaged,
    even if it can be read.
    """

    def __init__(
        self, folder: Path, survey_id: str, sealed: Optional[Manifest], on_trace: OnTrace
    ) -> None:
        """Read everything.

        Args:
            folder: The survey's folder.
            survey_id: Whose traces there must be.
            sealed: The manifest, if there is a whole one.
            on_trace: Called with every trace of every form.

        Raises:
            OSError: The disk cannot be read.
        """
        self._folder = folder
        self._survey_id = survey_id
        self._sealed = sealed
        # The manifest if a file that differs from it is damaged: after a reopening, files change.
        self._binding = sealed if sealed is not None and sealed.reopened is None else None
        self._on_trace = on_trace
        self._sums: Dict[str, Optional[FileSum]] = {}  # of the recordings and survey.json
        traces = folder / survey_folder.TRACES_FOLDER
        self.files = trace_files.read_all(traces, survey_id, on_trace=on_trace)
        self._leave_out_changed_files(traces)
        self.stored_bag = StoredBag(folder / survey_folder.BAG_FILE)
        self.bag = RecordedTraces(self.stored_bag)
        self.mcap = RecordedTraces(StoredMcap(folder / survey_folder.MCAP_FILE))
        for one in self.recordings:
            one.read(self._read_trace)
            if self.is_changed(one.name):
                one.faults.insert(0, _differs(one.name))
        self._types: Dict[str, Type] = {}
        if not self.mcap.faults:
            self._types = {
                topic: next(iter(types))
                for topic, types in self.mcap.types.items()
                if len(types) == 1
            }
        self.bag.compare_types(self._types)
        self._unconfirmed: Set[int] = set()  # in one form only, which has no checksum
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
            and all(map(self.is_certain, manifest.DATA_FILES))
            and all(map(self._is_certain_file, self.files.files))
            and not self.other_changes()
        )

    def is_certain(self, name: str) -> bool:
        """Return whether a file is as it was when the manifest was written."""
        return self._sealed is not None and self._sealed.matches(name, self._sum(name))

    def is_changed(self, name: str) -> bool:
        """Return whether a file should be as in the manifest, but is not."""
        return self._binding is not None and not self._binding.matches(name, self._sum(name))

    def other_changes(self) -> List[Message]:
        """Return how files that hold no data differ from the manifest."""
        binding = self._binding
        if binding is None:
            return []
        listed = binding.files
        names = {*listed, *sealing.file_names(self._folder)}
        return [
            _differs(name)
            for name in sorted(names)
            if not manifest.is_data(name)
            and listed.get(name, _NOT_LISTED) is not None
            and not binding.matches(name, self._sum(name))
        ]

    def source_of(self, recorded: RecordedTraces) -> RecordedTraces:
        """Return the recording from which one that is written again is copied."""
        (other,) = (one for one in self.recordings if one is not recorded)
        if not self.is_certain(recorded.name) and self.is_certain(other.name):
            return other
        return recorded

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

    def _read_trace(self, message: RecordedMessage) -> Optional[Trace]:
        trace = self.trace_of(message)
        if trace is not None:
            self._on_trace(trace)
        return trace

    def _leave_out_changed_files(self, traces: Path) -> None:
        if self._binding is None:
            return
        for index, file in list(self.files.files.items()):
            if not self._is_certain_file(index):
                self.files.damaged.append((traces / file.name, _differs(file.name)))
                del self.files.files[index]

    def _is_certain_file(self, index: int) -> bool:
        file = self.files.files[index]
        name = manifest.trace_name(file.name)
        return self._sealed is not None and self._sealed.matches(name, file.sum)

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
        certain = self._certain_prints()
        for index in sorted({index for prints in sources for index in prints}):
            if index in certain:
                truth[index] = certain[index]
                continue
            held = Counter(prints[index] for prints in sources if index in prints)
            (best, count), *others = held.most_common()
            contradicted = others or put_aside.get(index, set()) - {best}
            decided = best if count > 1 or not contradicted else self.mcap.prints.get(index)
            if decided is not None:
                truth[index] = decided
            if count == 1 and index not in self.mcap.prints:
                self._unconfirmed.add(index)
        return truth

    def leave_out(self, damaged: Set[int]) -> None:
        """Count traces as not stored if nothing but a form without a checksum holds them.

        Args:
            damaged: Places of traces that the survey did not plan so. A flipped bit makes such a
                trace of a right one, whose place it leaves.
        """
        for index in damaged & self._unconfirmed:
            self.truth.pop(index, None)

    def _certain_prints(self) -> Dict[int, bytes]:
        """Return the traces of the files that are as in the manifest."""
        found: Dict[int, bytes] = {}
        for recorded in self.recordings:
            if self.is_certain(recorded.name):
                found.update(recorded.prints)
        found.update(
            (index, file.fingerprint)
            for index, file in self.files.files.items()
            if self._is_certain_file(index)
        )
        return found

    def _sum(self, name: str) -> Optional[FileSum]:
        if name not in self._sums:
            try:
                self._sums[name] = file_sums.sum_of_file(self._folder / name)
            except OSError:
                self._sums[name] = None
        return self._sums[name]


def _differs(name: str) -> Message:
    return Message("{file} differs from the manifest", file=name)
