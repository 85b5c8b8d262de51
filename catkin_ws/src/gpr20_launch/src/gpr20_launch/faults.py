"""The faults of a launch and of the robot's configuration."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

NOT_CHECKED = Fault(
    "config.not_checked", Message("Check what the message names, as it says, before a survey.")
)
