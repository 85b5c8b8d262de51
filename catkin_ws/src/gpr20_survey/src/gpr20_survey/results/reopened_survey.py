"""A survey that was opened again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from gpr20_common.message import Message
from gpr20_survey.trace.trace import Trace

# As many contain a whole stop of a survey with up to four rotations.
RECENT_TRACES = 8
# The first stop of a survey with up to four rotations, with which its drift is compared.
FIRST_TRACES = 4


@dataclass(frozen=True)
class ReopenedSurvey:
    """A survey that was cut off or ended early, open again: what reopen_survey answers.

    Attributes:
        path: Its folder, on the computer of the storage.
        metadata_json: As it was recorded at its start.
        report_json: Its last report; empty if none exists.
        stored_indices: Indices in the plan of the stored, readable traces, ascending.
        recent: Those of the first traces of the plan that are stored, and the traces stored last,
            the latest last.
        repairs: What was repaired; the answer has it as a part of its sentence only.
        interrupted: Folder of another survey that was still open and was closed; empty if none.
    """

    survey_id: str
    path: str
    metadata_json: str
    report_json: str
    stored_indices: Tuple[int, ...]
    recent: Tuple[Trace, ...]
    repairs: Tuple[Message, ...] = ()
    interrupted: str = ""
