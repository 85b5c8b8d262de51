"""The faults of a survey and of maintenance, and what to do first about each."""

from __future__ import annotations

from dataclasses import replace

from gpr20_common.message import Fault, Message, Severity
from gpr20_survey.faults import DAMAGED

BLOCKED = Fault(
    "survey.blocked",
    Message(
        "Look for anything that blocks or touches the axis, and for whoever stopped it. Press STOP "
        "before you reach in. When the axis is clear, resume the survey, or home the axis on ROBOT."
    ),
)
MOVED_BY_OTHERS = Fault(
    "survey.moved_by_others",
    Message(
        "Let no person and no other program move or home the axes or set a zero. Resume the "
        "survey: it homes the axis itself where it can, and measures a known point again."
    ),
)
DRIFTED = Fault(
    "survey.drifted",
    Message(
        "Check that nothing was moved below the first stop, and the antenna cables and their "
        "connectors; let the VNA warm up. Resume the survey: it measures the first stop again and "
        "continues from there."
    ),
)
OTHER_ROBOT = Fault(
    "survey.other_robot",
    Message(
        "Start the robot and the configuration with which the survey began, then resume the "
        "survey. Or plan a new one."
    ),
    can_continue=False,
)
CONFIGURATION_CHANGED = replace(OTHER_ROBOT, can_continue=True)
# What is stored of the survey cannot be continued.
RECORD_DAMAGED = replace(DAMAGED, can_continue=False)
STOPPED_BEFORE = Fault(
    "survey.stopped_before",
    Message("If nobody is in danger, press START, RESUME or the service button again."),
    Severity.NOTE,
)
