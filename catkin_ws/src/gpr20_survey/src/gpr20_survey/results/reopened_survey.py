"""A survey that was opened again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from gpr20_common.message import Message
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class ReopenedSurvey:
    """A survey that was cut off or ended early, open again: the answer of reopen_survey.

    Attributes:
        recent: Those of the first traces of the plan that are stored, and the traces stored last,
            the latest last.
        repairs: What was repaired; the answer has it as a part of its sentence only.
    """

    survey_id: str
    path: str
    metadata_json: str
    report_json: str
    stored_indices: Tuple[int, ...]
    recent: Tuple[Trace, ...]
    repairs: Tuple[Message, ...] = ()
    interrupted: str = ""
