"""Why START is locked."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message
from gpr20_operator.plan.form import PlanCheck
from gpr20_operator.plan.tiles import first_problem
from gpr20_operator.robot.events import Request
from gpr20_operator.robot.survey_model import Snapshot


def start_lock(snapshot: Optional[Snapshot], check: PlanCheck) -> Optional[Message]:
    """Return why no survey can be started now; None if one can.

    Args:
        snapshot: What is known of the robot; None: nothing yet.
        check: Of the plan.
    """
    if snapshot is None or (not snapshot.control_alive and snapshot.replay is None):
        return Message("No contact with the robot")
    if snapshot.replay is not None:
        return Message("A replay is shown")
    if Request.START in snapshot.pending:
        return Message("The survey is starting")
    if snapshot.running:
        return Message("A survey is running")
    return first_problem(check)
