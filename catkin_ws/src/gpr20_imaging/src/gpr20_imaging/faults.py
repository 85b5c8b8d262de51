"""The faults that the imaging node can report."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

FAILED = Fault(
    "imaging.failed",
    Message(
        "Try again. If it fails again, copy the survey to a USB stick and analyze it on another "
        "computer."
    ),
)
NOT_INSTALLED = Fault(
    "imaging.not_installed",
    Message(
        "Copy the survey to a USB stick and analyze it on another computer, or ask the person who "
        "maintains the robot to install the analysis."
    ),
)
TOO_MUCH = Fault(
    "imaging.too_much",
    Message("Copy the survey to a USB stick and analyze it on a computer with more memory."),
)
CANCELLED = Fault("imaging.cancelled", Message("Nothing to do: it was asked for."), Severity.NOTE)
NO_REQUEST = Fault(
    "imaging.no_request", Message("Nothing to do: the request has ended."), Severity.NOTE
)
BUSY = Fault("imaging.busy", remedies.TRY_LATER)
NOTHING_CHOSEN = Fault("imaging.nothing_chosen", Message("Choose at least one kind of file."))
STICK_FAILED = Fault(
    "imaging.stick_failed",
    Message("Plug the USB stick in again, or use another one. Then export again."),
)
STICK_GONE = Fault(
    "imaging.stick_gone", Message("Plug the USB stick in, wait a moment and choose it again.")
)
STICK_FULL = Fault(
    "imaging.stick_full", Message("Make space on the USB stick, or use another one.")
)
STICK_FOLDER = Fault(
    "imaging.stick_folder",
    Message(
        "Rename what has this name on the USB stick, or use another one. What was there is "
        "untouched."
    ),
)
STICK_FORMAT = Fault(
    "imaging.stick_format",
    Message("Use another USB stick, or format this one as exFAT: that deletes what is on it."),
)
STICK_PROTECTED = Fault(
    "imaging.stick_protected",
    Message("Remove the USB stick's write protection, or use another stick."),
)
NO_STICK_LIST = Fault(
    "imaging.no_stick_list",
    Message("Ask the person who maintains the robot to check the program lsblk on the computer."),
)
