"""What is wrong with a launch or with a robot's configuration."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Fault, Message

NOT_CHECKED = Fault(
    "config.not_checked", Message("Check what the message names, as it says, before a survey.")
)


class LaunchRefusedError(Gpr20Error, RuntimeError):
    """A robot cannot be launched as requested."""

    fault = NOT_ALLOWED
