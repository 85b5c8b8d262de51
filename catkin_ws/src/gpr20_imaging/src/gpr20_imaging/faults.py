"""What the imaging node refuses, what fails in it, and the faults that it reports."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
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


class ImagingError(Gpr20Error):
    """A request to the imaging node was refused or failed."""

    fault = OTHER_COMPUTER


class StickError(ImagingError):
    """The USB stick is missing, full, or not what it was."""

    fault = STICK
