"""Errors of a survey."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import IN_USE, INTERNAL, PART_RED, PART_SILENT
from gpr20_common.message import Message
from gpr20_survey.faults import STOPPED, VNA_FAILED, VNA_REPLACED

# The storage refuses to close a survey for a reason of more than 4096 characters.
MAX_DETAILS = 1000


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
