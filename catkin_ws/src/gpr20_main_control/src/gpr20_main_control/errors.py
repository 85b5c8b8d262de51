"""Errors of a survey."""

from __future__ import annotations

from typing import Optional

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.message import Fault, Message
from gpr20_main_control import faults

# The storage refuses to close a survey for a reason of more than 4096 characters.
MAX_DETAILS = 1000


class SurveyError(Gpr20Error):
    """A survey was refused or failed."""

    fault = faults.SURVEY_FAILED


class RequestRefusedError(SurveyError, RuntimeError):
    """A request is not possible in the present state."""

    fault = faults.SURVEY_IN_PROGRESS


class DeviceError(SurveyError, OSError):
    """A part of the robot failed; the survey pauses and can be resumed."""

    fault = faults.DEVICE_FAILED


class NodeLostError(DeviceError):
    """There is no contact with a node, or it was restarted; the survey waits until it is back."""

    fault = faults.NODE_LOST


class UnconfirmedError(DeviceError):
    """A sweep could not be confirmed: it is not stored.

    Attributes:
        repeat: Whether the same point should be measured again at once.
    """

    fault = faults.SWEEP_UNCONFIRMED

    def __init__(self, message: Message, repeat: bool) -> None:
        super().__init__(message)
        self.repeat = repeat


class OtherAnalyzerError(DeviceError):
    """The analyzer is not the one that the survey was measured with.

    Attributes:
        identity: That of the present analyzer, if the survey was measured with another one.
    """

    fault = faults.OTHER_VNA

    def __init__(self, message: Message, identity: str, fault: Optional[Fault] = None) -> None:
        super().__init__(message, fault)
        self.identity = identity


class StopRequested(SurveyError):
    """A stop of the survey was requested."""

    fault = faults.STOPPED_ON_REQUEST


class ShutDownRequested(StopRequested):
    """The main control ends, usually with the whole robot."""

    fault = faults.ROBOT_SHUT_DOWN


def message_of(error: Exception) -> Message:
    """Return the message of an error; a fault in the software has a general one."""
    if isinstance(error, Gpr20Error):
        return error.message
    details = f"{type(error).__name__}: {error}"[:MAX_DETAILS]
    return Message("internal error in the main control", details=details).with_fault(INTERNAL)
