"""The plan that START from the page measures: what identifies it, and what a person reads of it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from typing import Any, Callable, Mapping

from gpr20_common.message import Message
from gpr20_operator.plan.form import preview
from gpr20_operator.plan.hold_question import HANDS_CLEAR
from gpr20_operator.plan.tiles import plan_rows, spacing_warning
from gpr20_operator.robot.events import StartPlan

# Of ground of which nothing is known.
AIR = 1.0


def plan_id(plan: StartPlan) -> str:
    """Return what only this plan has: a person starts the plan that was read."""
    content = json.dumps(asdict(plan), sort_keys=True, default=str)
    return hashlib.sha256(content.encode()).hexdigest()[:32]


def plan_values(plan: StartPlan, text: Callable[[Message], str]) -> Mapping[str, Any]:
    """Return what a browser shows before START."""
    permittivity = plan.permittivity or AIR
    known = preview(plan.parameters, permittivity)
    rows = plan_rows(plan.parameters, permittivity, known, plan.annotation)
    doubt = spacing_warning(known)
    return {
        "id": plan_id(plan),
        "rows": [[text(name), text(value)] for name, value in rows],
        "doubt": "" if doubt is None else text(doubt),
        "warning": text(HANDS_CLEAR),
    }
