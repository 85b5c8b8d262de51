"""Which survey a finer one was planned from, so that both are shown together."""

from __future__ import annotations

from typing import Any, Mapping

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.trace.trace import SURVEY_ID

REFINES = "refines"
"""Key of the description; only in a survey that measures a part of another one more finely."""


def check_refines(survey_id: str) -> str:
    """Return the id if it is empty or that of a survey.

    Raises:
        InvalidValueError: It is anything else.
    """
    if survey_id and not SURVEY_ID.fullmatch(survey_id):
        raise InvalidValueError(
            Message(
                "refines is {survey}; it must be empty or a survey's id, a UUID in lower case "
                "with hyphens",
                survey=repr(survey_id[:64]),
            )
        )
    return survey_id


def refines_of(description: Mapping[str, Any]) -> str:
    """Return the id of the survey that one refines; empty if it refines none.

    Args:
        description: What the log says of the survey. An entry that is no survey's id counts as
            none: it only says what to show beside the survey.
    """
    value = description.get(REFINES)
    return value if isinstance(value, str) and SURVEY_ID.fullmatch(value) else ""
