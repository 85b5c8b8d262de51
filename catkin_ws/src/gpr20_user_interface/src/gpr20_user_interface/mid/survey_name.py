"""What people call a survey, from its description."""

from __future__ import annotations

import json


def survey_name(description: str) -> str:
    """Return the name of a survey, or its site; empty if it has neither.

    Args:
        description: The text of its survey.json.
    """
    try:
        annotation = json.loads(description).get("annotation", {})
        return str(annotation.get("name") or annotation.get("site") or "")
    except (ValueError, AttributeError):
        # Who reads the plan from the same text reports what is wrong with it.
        return ""
