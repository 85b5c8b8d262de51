"""A survey that was opened again, as fields of the answer of reopen_survey, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Tuple

from gpr20_common.message import Message
from gpr20_survey.trace.trace import Trace

# As many contain a whole stop of a survey with up to four rotations.
RECENT_TRACES = 8
# The first stop of a survey with up to four rotations, with which its drift is compared.
FIRST_TRACES = 4


@dataclass(frozen=True)
class ReopenedSurvey:
    """A survey that was cut off or ended early, open again.

    Attributes:
        survey_id: UUID.
        folder: Path of its folder, on the computer of the storage.
        metadata_json: As it was recorded at its start.
        report_json: Its last report; empty if none exists.
        stored_indices: Indices in the plan of the stored, readable traces, ascending.
        recent: Those of the first traces of the plan that are stored, and the traces stored last,
            the latest last.
        repairs: What was repaired; the answer has it as a part of its sentence only.
        interrupted: Folder of another survey that was still open and was closed; empty if none.
    """

    survey_id: str
    folder: str
    metadata_json: str
    report_json: str
    stored_indices: Tuple[int, ...]
    recent: Tuple[Trace, ...]
    repairs: Tuple[Message, ...] = ()
    interrupted: str = ""


PLAIN = ("survey_id", "metadata_json", "report_json", "interrupted")


def reopened_fields(reopened: ReopenedSurvey) -> Dict[str, Any]:
    """Return the fields of an answer without its sentence and its traces."""
    plain = {name: getattr(reopened, name) for name in PLAIN}
    return {**plain, "path": reopened.folder, "stored_indices": reopened.stored_indices}


def reopened_from(answer: Any, recent: Tuple[Trace, ...]) -> ReopenedSurvey:
    """Return the survey of an answer.

    Args:
        answer: The fields.
        recent: Its traces.
    """
    return ReopenedSurvey(
        folder=answer.path,
        stored_indices=tuple(answer.stored_indices),
        recent=recent,
        **{name: getattr(answer, name) for name in PLAIN},
    )
