"""The faults of the storage that stores a survey."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

CLOSING = Fault(
    "survey.closing", Message("Press STOP again: the survey's recordings are not finished yet.")
)
BAG_MISSING = Fault(
    "storage.bag_missing",
    Message("Make space if the disk is full, then make the bag with the command that is shown."),
    severity=Severity.WARNING,
)
