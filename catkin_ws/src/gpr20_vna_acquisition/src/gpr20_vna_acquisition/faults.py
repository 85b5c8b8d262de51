"""What can go wrong with the network analyzer, for programs."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

LOCKED = Fault(
    "vna.locked",
    Message(
        "Close the other program that uses the VNA. If there is none, switch the VNA off and on."
    ),
)
NOT_CONNECTED = Fault(
    "vna.not_connected",
    Message("Start or resume a survey, or test the VNA on ROBOT: that connects it and sets it up."),
)
