"""Check of a survey's recordings against its JSON files, and against each other."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from pathlib import Path
from typing import Callable, Dict, List, Set, Tuple

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.progress import Progress
from gpr20_analysis.read import description_check
from gpr20_analysis.read.recordings import trace_messages
from gpr20_analysis.read.trace_table import of_other_survey
from gpr20_analysis.read.verification_result import Verification
from gpr20_common.message import Message
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

Type = Tuple[str, str, str, bool]
# Topic, time [ns] and the first bytes of a checksum of a message.
Key = Tuple[str, int, bytes]


class RecordingComparison:
    """What the bag and the MCAP of a survey, read from their beginning to their end, contain.

    The chunks of the MCAP have checksums, those of the bag have none: a message of the bag is
    only right for certain if the MCAP has it too.
    """

    def __init__(self, folder: Path) -> None:
        """Read both.

        Raises:
            OSError: A file cannot be read.
        """
        bag = StoredBag(folder / survey_folder.BAG_FILE)
        mcap = StoredMcap(folder / survey_folder.MCAP_FILE)
        self.faults: List[Message] = []
        self.alone = 0
        """Number of messages that only one of the recordings contains."""
        self._types: Tuple[Dict[str, Set[Type]], Dict[str, Set[Type]]] = ({}, {})
        # Of each message, how many more of it the MCAP has than the bag; both are in nearly the
        # same order, so few are left at any time.
        surplus: Counter[Key] = Counter()
        for own, other in itertools.zip_longest(bag.messages(), mcap.messages()):
            for number, (message, change) in enumerate(((own, -1), (other, 1))):
                if message is not None:
                    self._note(surplus, message, change, self._types[number])
        readable = bag.path.exists() and mcap.path.exists()
        self.faults += [*bag.faults, *bag.frame_faults(), *mcap.faults, *mcap.frame_faults()]
        if readable and not self.faults:
            self._compare(surplus)

    def _note(
        self,
        surplus: Counter[Key],
        message: RecordedMessage,
        change: int,
        types: Dict[str, Set[Type]],
    ) -> None:
        own_type = (message.datatype, message.md5sum, message.definition, message.latching)
        types.setdefault(message.topic, set()).add(own_type)
        digest = hashlib.blake2b(message.data, digest_size=8).digest()
        key = (message.topic, message.time_ns, digest)
        surplus[key] += change
        if not surplus[key]:
            del surplus[key]

    def _compare(self, surplus: Counter[Key]) -> None:
        in_bag = {key[:2] for key, count in surplus.items() if count < 0}
        in_mcap = {key[:2] for key, count in surplus.items() if count > 0}
        for topic, time_ns in sorted(in_bag & in_mcap):
            self.faults.append(
                Message(
                    "the message of {topic} at {time_s:.9f} s has other content in survey.bag "
                    "than in survey.mcap",
                    topic=topic,
                    time_s=time_ns / 1e9,
                )
            )
        self.alone = sum(map(abs, surplus.values()))
        in_bag_types, in_mcap_types = self._types
        for topic in sorted(in_bag_types.keys() & in_mcap_types.keys()):
            if in_bag_types[topic] != in_mcap_types[topic]:
                self.faults.append(
                    Message(
                        "topic {topic} has another message type in survey.bag than in survey.mcap",
                        topic=topic,
                    )
                )


class RecordingCheck:
    """Checks the recordings of one survey."""

    def __init__(
        self,
        folder: Path,
        survey_id: str,
        indexed: bool,
        found: Verification,
        progress: Progress,
    ) -> None:
        """Check nothing yet.

        Args:
            folder: The survey's folder.
            survey_id: UUID of the survey.
            indexed: Whether the recordings were finished, so they have their index.
            found: Faults and notes are added here.
            progress: Shows the progress of each pass over the traces.
        """
        self._folder = folder
        self._survey_id = survey_id
        self._indexed = indexed
        self._found = found
        self._progress = progress

    def check(self, stored: Dict[int, bytes], on_trace: Callable[[Trace], None]) -> None:
        """Compare the traces of both recordings; without a manifest, also their other messages.

        Args:
            stored: Fingerprint of each trace that has a readable JSON file.
            on_trace: Called with each trace in the order of measurement.
        """
        before = len(self._found.faults)
        self._check_traces(stored, on_trace)
        if not self._found.sealed and len(self._found.faults) == before:
            self._compare_recordings(stored)

    def _check_traces(self, stored: Dict[int, bytes], on_trace: Callable[[Trace], None]) -> None:
        for name in (survey_folder.BAG_FILE, survey_folder.MCAP_FILE):
            before = len(self._found.faults)
            # Both are in the order of measurement.
            note = on_trace if name == survey_folder.MCAP_FILE else _ignore
            recorded = self._recorded_prints(name, len(stored), note)
            if len(self._found.faults) == before:
                self._check_missing(name, sorted(stored.keys() - recorded.keys()))
            for index in sorted(recorded.keys() & stored.keys()):
                if recorded[index] != stored[index]:
                    self._found.fault(
                        Message(
                            "trace {index} has other values in {file} than in its JSON file",
                            index=index,
                            file=name,
                        )
                    )
            for index in sorted(recorded.keys() - stored.keys()):
                self._found.fault(
                    Message(
                        "trace {index} is in {file} but has no readable JSON file",
                        index=index,
                        file=name,
                    )
                )

    def _recorded_prints(
        self, name: str, expected: int, on_trace: Callable[[Trace], None]
    ) -> Dict[int, bytes]:
        """Return the fingerprint of each trace of a recording."""
        prints: Dict[int, bytes] = {}
        messages = trace_messages(self._folder / name, self._indexed)
        try:
            for message in self._progress(messages, expected):
                trace = trace_message.decode(message.data, message.md5sum)
                if trace.survey_id != self._survey_id:
                    reason = of_other_survey(trace)
                    self._found.fault(Message("{file}: {reason}", file=name, reason=reason))
                elif trace.index in prints:
                    self._found.fault(
                        Message(
                            "{file} contains trace {index} more than once",
                            file=name,
                            index=trace.index,
                        )
                    )
                else:
                    prints[trace.index] = trace.fingerprint()
                    on_trace(trace)
        except (UnreadableFileError, TraceRefusedError) as error:
            self._found.fault(
                Message(
                    "{file} cannot be read to its end: {reason}", file=name, reason=error.message
                )
            )
        return prints

    def _compare_recordings(self, stored: Dict[int, bytes]) -> None:
        """Check all that has a checksum or a second copy; no manifest covers the files."""
        compared = RecordingComparison(self._folder)
        self._found.faults += compared.faults
        if compared.alone:
            self._found.note(
                Message(
                    "{count} messages are in only one of the recordings, as after a crash",
                    count=compared.alone,
                )
            )
        if stored and not description_check.has_sealed_copy(self._folder):
            self._found.fault(Message("survey.mcap contains no readable copy of survey.json"))

    def _check_missing(self, name: str, missing: List[int]) -> None:
        # The JSON file is written first: a crash may come between it and a recording, but the
        # next trace is not stored before this one is in both.
        if len(missing) == 1 and not self._indexed:
            self._found.note(
                Message(
                    "trace {index} is not in {file} yet; it is added when the survey is resumed",
                    index=missing[0],
                    file=name,
                )
            )
            return
        for index in missing:
            self._found.fault(
                Message(
                    "trace {index} has a JSON file but is not in {file}", index=index, file=name
                )
            )


def _ignore(_trace: Trace) -> None:
    """Take a trace that was checked in the other recording."""
