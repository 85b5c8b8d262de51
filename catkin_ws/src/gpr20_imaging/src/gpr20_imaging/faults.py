"""The faults that the imaging node can report."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

OTHER_COMPUTER = Fault(
    "imaging.other_computer",
    Message("Copy the survey to a USB stick and analyze it on another computer, with more memory."),
)
STICK = Fault(
    "imaging.stick",
    Message(
        "Plug the USB stick in again, or use another one: with space, formatted as exFAT, and not "
        "write-protected. Then export again."
    ),
)
