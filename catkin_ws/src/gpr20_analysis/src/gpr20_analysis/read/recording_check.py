"""Check of a survey's recordings against its JSON files."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.progress import Progress
from gpr20_analysis.read.recordings import trace_messages
from gpr20_analysis.read.trace_table import of_other_survey
from gpr20_analysis.read.verification_result import Verification
from gpr20_common.message import Message
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.trace import trace_message


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

    def check(self, stored: Dict[int, bytes]) -> None:
        """Compare the traces of the MCAP, and those of the bag if the survey was closed.

        The bag of a survey that was not closed is written again when it is resumed.

        Args:
            stored: Fingerprint of each trace that has a readable JSON file.
        """
        # An imported survey has none.
        if self._indexed and self._found.imported is None:
            self._check_traces(survey_folder.BAG_FILE, stored)
        before = len(self._found.faults)
        self._check_traces(survey_folder.MCAP_FILE, stored)
        if not self._found.sealed and len(self._found.faults) == before:
            self._check_frame()

    def _check_traces(self, name: str, stored: Dict[int, bytes]) -> None:
        before = len(self._found.faults)
        recorded = self._recorded_prints(name, len(stored))
        if len(self._found.faults) == before and not self._found.writer:
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
        if self._found.writer:
            return  # the recording was read later than the JSON files
        for index in sorted(recorded.keys() - stored.keys()):
            self._found.fault(
                Message(
                    "trace {index} is in {file} but has no readable JSON file",
                    index=index,
                    file=name,
                )
            )

    def _recorded_prints(self, name: str, expected: int) -> Dict[int, bytes]:
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
        except (UnreadableFileError, TraceRefusedError) as error:
            self._found.fault(
                Message(
                    "{file} cannot be read to its end: {reason}", file=name, reason=error.message
                )
            )
        return prints

    def _check_frame(self) -> None:
        """Check what is outside the traces of the MCAP; no manifest covers the file."""
        mcap = StoredMcap(self._folder / survey_folder.MCAP_FILE)
        for _message in mcap.messages():
            pass  # its faults are known at its end
        self._found.faults += [*mcap.faults, *mcap.frame_faults()]

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
