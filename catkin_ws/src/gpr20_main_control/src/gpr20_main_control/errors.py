"""Errors of a survey and of maintenance, and the faults that only the main control reports."""

from __future__ import annotations

from dataclasses import replace

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import IN_USE, INTERNAL, PART_RED, PART_SILENT
from gpr20_common.message import Fault, Message, Severity
from gpr20_survey.faults import DAMAGED, STOPPED, VNA_FAILED, VNA_REPLACED

# The storage refuses to close a survey for a reason of more than 4096 characters.
MAX_DETAILS = 1000

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


class SurveyError(Gpr20Error):
    """A survey was refused or failed."""

    fault = PART_RED


class RequestRefusedError(SurveyError, RuntimeError):
    """A request is not possible in the present state."""

    fault = IN_USE


class DeviceError(SurveyError, OSError):
    """A part of the robot failed; the survey pauses and can be resumed."""


class NodeLostError(DeviceError):
    """There is no contact with a node, or it was restarted; the survey waits until it is back."""

    fault = PART_SILENT


class UnconfirmedError(DeviceError):
    """A sweep could not be confirmed: it is not stored; `repeat` its point at once, or not."""

    fault = VNA_FAILED

    def __init__(self, message: Message, repeat: bool) -> None:
        super().__init__(message)
        self.repeat = repeat


class OtherAnalyzerError(DeviceError):
    """The analyzer, which has this identity, is not the one that the survey was measured with."""

    fault = VNA_REPLACED

    def __init__(self, message: Message, identity: str) -> None:
        super().__init__(message)
        self.identity = identity


class StopRequested(SurveyError):
    """A stop of the survey was requested."""

    fault = STOPPED


class ShutDownRequested(StopRequested):
    """The main control ends, usually with the whole robot."""


def message_of(error: Exception) -> Message:
    """Return the message of an error; a fault in the software has a general one."""
    if isinstance(error, Gpr20Error):
        return error.message
    details = f"{type(error).__name__}: {error}"[:MAX_DETAILS]
    return Message("internal error in the main control", details=details).with_fault(INTERNAL)
