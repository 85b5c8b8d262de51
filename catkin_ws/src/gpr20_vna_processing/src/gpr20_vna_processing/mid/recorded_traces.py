"""The traces of one recording of a survey, as they were found on the disk."""

from __future__ import annotations

import dataclasses
from typing import Callable, Dict, List, Optional, Set, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import ForeignTraceError, TraceRefusedError
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.stored_recording import StoredRecording
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
