"""What people call a survey, and which survey it is, from its description."""

from __future__ import annotations

import json
from typing import Tuple


def survey_name(description: str) -> Tuple[str, str]:
    """Return the id of a survey, and its name or its site; empty what it does not have.

    Args:
        description: The text of its survey.json.
    """
    try:
        values = json.loads(description)
        annotation = values.get("annotation") or {}
        name = annotation.get("name") or annotation.get("site") or ""
        return str(values.get("survey_id", "")), str(name)
    except (ValueError, AttributeError):
        # Who reads the plan from the same text reports what is wrong with it.
        return "", ""
