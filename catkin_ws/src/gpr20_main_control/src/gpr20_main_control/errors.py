"""What can go wrong with a survey."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class SurveyError(Gpr20Error):
    """A survey was refused or failed."""


class RequestRefusedError(SurveyError, RuntimeError):
    """A request does not fit what the control is doing now."""


class DeviceError(SurveyError, OSError):
    """A part of the robot failed; the survey pauses and can be resumed."""


class NodeLostError(DeviceError):
    """A node is gone, or is another than before; the survey holds until it is back."""


class StopRequested(SurveyError):
    """A stop of the survey was requested."""
