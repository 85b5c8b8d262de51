"""The traces in a recording that is on the disk already."""

from __future__ import annotations

import dataclasses
import secrets
from typing import Dict, Iterator, List, Optional, Set, Tuple

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder.survey_folder import DAMAGED_FOLDER
from gpr20_survey.recording.recording import RecordedMessage, Recording
from gpr20_survey.recording.stored_recording import StoredRecording
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.open_survey import COMMIT_BYTES, MessageMaker

# Topic and checksum of a type -> its name and its definition.
Types = Dict[Tuple[str, str], Tuple[str, str]]


class RecordedTraces:
    """Knows which traces a recording holds and what is wrong with it."""

    def __init__(self, recording: StoredRecording, messages: MessageMaker, survey_id: str) -> None:
        """Read the whole recording.

        Raises:
            OSError: The file cannot be read.
        """
        self._recording = recording
        self._messages = messages
        self._survey_id = survey_id
        self.prints: Dict[int, bytes] = {}
        self.types: Types = {}
        self.faults: List[str] = []
        self._read()

    @property
    def name(self) -> str:
        """File name."""
        return self._recording.path.name

    @property
    def has_checksums(self) -> bool:
        """Whether what it holds is protected by checksums."""
        return self._recording.has_checksums

    def compare_types(self, sure: Types) -> None:
        """Note a fault for every topic whose type differs from that in a sure recording."""
        topics = {topic for topic, _ in sure}
        for (topic, md5sum), own in self.types.items():
            if topic in topics and sure.get((topic, md5sum)) != own:
                self.faults.append(f"{self.name} holds a damaged type of {topic}")

    def _read(self) -> None:
        self.prints, self.types, self.faults = {}, {}, []
        for message in self._recording.messages():
            self._look_at(message)
        self.faults = [*self._recording.faults, *self.faults]

    def _look_at(self, message: RecordedMessage) -> None:
        key = (message.topic, message.md5sum)
        self.types.setdefault(key, (message.datatype, message.definition))
        try:
            trace = self._trace_of(message)
        except TraceRefusedError as error:
            self.faults.append(f"{self.name} holds a damaged trace: {error}")
            return
        if trace is None:
            return
        if trace.index in self.prints:
            self.faults.append(f"{self.name} holds trace {trace.index} twice")
            return
        self.prints[trace.index] = trace.fingerprint()

    def _trace_of(self, message: RecordedMessage) -> Optional[Trace]:
        trace = self._messages.recorded_trace(message)
        if trace is not None and trace.survey_id != self._survey_id:
            raise TraceRefusedError(f"{trace.label} belongs to survey {trace.survey_id}")
        return trace

    def traces(self) -> Iterator[Trace]:
        """Yield the traces that can be read."""
        for message in self._recording.messages():
            try:
                trace = self._trace_of(message)
            except TraceRefusedError:
                continue  # told among the faults
            if trace is not None:
                yield trace

    def resume(self) -> Recording:
        """Go on with the recording behind what is whole.

        Raises:
            OSError: The disk refused.
        """
        return self._recording.resume()

    def rebuild(self, truth: Dict[int, bytes], types: Types) -> None:
        """Put a new file in the place of the damaged one, which is kept aside.

        All readable messages are in the new file, of the traces only the true ones, each
        once. The old file stays in its place until the new one is whole and durable.

        Args:
            truth: Fingerprint of each trace.
            types: Those that are known for sure.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        path = self._recording.path
        name = f"{durable_files.TEMPORARY_PREFIX}{path.name}.{secrets.token_hex(4)}"
        temporary = path.with_name(name + durable_files.TEMPORARY_SUFFIX)
        new = self._recording.create(temporary)
        try:
            self._copy_to(new, truth, types)
            new.finish()
        except BaseException:
            new.abandon()
            temporary.unlink()
            raise
        durable_files.keep_aside(path, path.parent / DAMAGED_FOLDER)
        durable_files.put_in_place(temporary, path)
        self._read()

    def _copy_to(self, new: Recording, truth: Dict[int, bytes], types: Types) -> None:
        written: Set[int] = set()
        for message in self._recording.messages():
            try:
                trace = self._trace_of(message)
            except TraceRefusedError:
                continue  # told among the faults; the damaged file is kept
            own = (message.datatype, message.definition)
            datatype, definition = types.get((message.topic, message.md5sum), own)
            message = dataclasses.replace(message, datatype=datatype, definition=definition)
            if trace is None:
                new.write(message)
            elif trace.index not in written and truth.get(trace.index) == trace.fingerprint():
                written.add(trace.index)
                new.begin_chunk()
                new.write(message)
                new.begin_chunk()
            if new.collected_bytes > COMMIT_BYTES:
                new.commit()
