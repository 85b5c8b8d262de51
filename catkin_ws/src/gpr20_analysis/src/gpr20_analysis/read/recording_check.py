"""Check of a survey's recording against its JSON files, and of its bag against its log."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Set

from gpr20_analysis.progress import Progress
from gpr20_analysis.read.trace_table import of_other_survey
from gpr20_analysis.read.verification_result import Verification
from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.file_sums import FileSum, sum_of_file
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_folder import BAG_FILE, MCAP_FILE
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.survey_topics import TEXT_TYPE, recorded_log
from gpr20_survey.trace import trace_message


def check_bag(
    folder: Path, records: Sequence[LogRecord], finished: bool, found: Verification
) -> None:
    """Compare survey.bag with the checksum in the log; without a bag the survey is complete.

    Nothing vouches for one that the log does not name.

    Args:
        folder: The survey's folder.
        records: Its log.
        finished: Whether the survey ended, so that it should have a bag.
        found: Faults and notes are added here.
    """
    expected, path = _recorded_bag(records), folder / BAG_FILE
    named = {"file": BAG_FILE, "folder": printable(folder)}
    if not os.path.lexists(str(path)):
        if finished:
            found.note(
                Message("{file} is missing; `gpr20 export --format bag {folder}` makes it", **named)
            )
        return
    try:
        present = sum_of_file(path)
    except OSError as error:
        reason = os_reason(error)
        found.fault(Message("{file} cannot be read: {reason}", file=BAG_FILE, reason=reason))
        return
    if expected is None:
        found.note(
            Message(
                "the log does not confirm {file}, as after a power cut; `gpr20 export --format bag "
                "{folder}` makes it again",
                **named,
            )
        )
        found.unconfirmed += (BAG_FILE,)
    elif present != expected:
        found.fault(
            Message(
                "{file} differs from its SHA-256 in the log; `gpr20 export --format bag {folder}` "
                "makes it again",
                **named,
            )
        )


def _recorded_bag(records: Sequence[LogRecord]) -> Optional[FileSum]:
    """Return the checksum of a bag that was made since the survey was resumed last."""
    for record in reversed(records):
        if record.kind == Kind.BAG.value:
            return FileSum(str(record.values.get("sha256")), record.values.get("size", -1))
        if record.kind == Kind.RESUME.value:
            return None
    return None


class RecordingCheck:
    """Checks the recording of one survey."""

    def __init__(
        self,
        folder: Path,
        survey_id: str,
        finished: bool,
        found: Verification,
        progress: Progress,
    ) -> None:
        """Check nothing yet.

        Args:
            folder: The survey's folder.
            survey_id: UUID of the survey.
            finished: Whether the survey ended, so that its recording was finished.
            found: Faults and notes are added here.
            progress: Shows the progress of each pass over the traces.
        """
        self._mcap = StoredMcap(folder / MCAP_FILE)
        self._survey_id = survey_id
        self._finished = finished
        self._found = found
        self._progress = progress

    def check(self, stored: Dict[int, bytes], log: Sequence[LogRecord]) -> None:
        """Compare the traces of the recording with the JSON files, and its log with the log.

        Args:
            stored: Fingerprint of each trace that has a readable JSON file.
            log: The records of the survey's log.
        """
        if not os.path.lexists(str(self._mcap.path)):
            self._found.fault(Message("{file} is missing", file=MCAP_FILE))
            return
        before = len(self._found.faults)
        recorded = self._recorded_prints(len(stored))
        if len(self._found.faults) == before and not self._found.writer:
            self._check_missing(sorted(stored.keys() - recorded.keys()))
        for index in sorted(recorded.keys() & stored.keys()):
            if recorded[index] != stored[index]:
                self._found.fault(
                    Message(
                        "trace {index} has other values in {file} than in its JSON file",
                        index=index,
                        file=MCAP_FILE,
                    )
                )
        if self._found.writer:
            return  # the recording was read later than the other files
        self._name_lost({one.sha256 for one in log})
        for index in sorted(recorded.keys() - stored.keys()):
            self._found.fault(
                Message(
                    "trace {index} is in {file} but has no readable JSON file",
                    index=index,
                    file=MCAP_FILE,
                )
            )

    def _recorded_prints(self, expected: int) -> Dict[int, bytes]:
        """Return the fingerprint of each trace of the recording."""
        prints: Dict[int, bytes] = {}
        messages = self._mcap.messages(trace_message.DATATYPE)
        try:
            for message in self._progress(messages, expected):
                trace = trace_message.decode(message.data, message.md5sum)
                if trace.survey_id != self._survey_id:
                    reason = of_other_survey(trace)
                    self._found.fault(Message("{file}: {reason}", file=MCAP_FILE, reason=reason))
                elif trace.index in prints:
                    self._found.fault(
                        Message(
                            "{file} contains trace {index} more than once",
                            file=MCAP_FILE,
                            index=trace.index,
                        )
                    )
                else:
                    prints[trace.index] = trace.fingerprint()
            self._found.faults += self._faults()
        except (OSError, TraceRefusedError) as error:
            reason = os_reason(error) if isinstance(error, OSError) else error.message
            self._found.fault(
                Message("{file} cannot be read to its end: {reason}", file=MCAP_FILE, reason=reason)
            )
        return prints

    def _name_lost(self, known: Set[str]) -> None:
        """Name the entries of the log that the recording alone holds, if the log does not."""
        named = self._found.unconfirmed
        with contextlib.suppress(OSError):  # that it cannot be read is said already
            for message in self._mcap.messages(TEXT_TYPE):
                record = recorded_log(message)
                if record is None or record.sha256 in known:
                    continue
                name = f"record {record.number}"
                if name not in named and f"{name}, {record.sha256[:8]}" not in named:
                    text = Message(
                        "entry {number} of the log, of kind {kind}, is in {file} alone",
                        number=record.number,
                        kind=record.kind,
                        file=MCAP_FILE,
                    )
                    self._found.note(text)
                    self._found.unconfirmed += (name,)

    def _faults(self) -> List[Message]:
        """Return what is damaged in the file; that it is cut off is one of an ended survey."""
        faults = [*self._mcap.faults]
        if self._finished and not faults and not self._mcap.is_finished():
            faults.append(
                Message("{file} has no complete end, although the survey ended", file=MCAP_FILE)
            )
        return faults

    def _check_missing(self, missing: List[int]) -> None:
        # The JSON file is written first: a crash may come between it and the recording, but the
        # next trace is not stored before this one is in both.
        if len(missing) == 1 and not self._finished:
            self._found.note(
                Message(
                    "trace {index} is not in {file} yet; it is added when the survey is resumed",
                    index=missing[0],
                    file=MCAP_FILE,
                )
            )
            return
        for index in missing:
            self._found.fault(
                Message(
                    "trace {index} has a JSON file but is not in {file}",
                    index=index,
                    file=MCAP_FILE,
                )
            )
