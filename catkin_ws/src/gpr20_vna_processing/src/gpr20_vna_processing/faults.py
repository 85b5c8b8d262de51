"""The faults of the storage that stores a survey."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity
from gpr20_survey.faults import DESCRIPTION_LOST

OTHER_OPEN = Fault("survey.other_open", remedies.OTHER_SURVEY)
NONE_OPEN = Fault("survey.none_open", Message("Start a survey, or resume one."))
CLOSING = Fault(
    "survey.closing", Message("Press STOP again: the survey's recordings are not finished yet.")
)
FOLDER_EXISTS = Fault(
    "survey.folder_exists",
    Message("Choose another survey id: the window does so when you start again."),
)
COMPLETE = Fault("survey.complete", remedies.NEW_SURVEY, severity=Severity.NOTE, can_continue=False)
TRACES_NOT_PLANNED = Fault("survey.traces_not_planned", DESCRIPTION_LOST.remedy, can_continue=False)
TRACE_ALREADY_STORED = Fault("trace.already_stored", remedies.KEEP_SURVEY)

DISK_SLOW = Fault(
    "disk.slow",
    Message("Check that the disk is plugged in and not full. End other programs that use it."),
)
BAG_MISSING = Fault(
    "storage.bag_missing",
    Message("Make space if the disk is full, then make the bag with the command that is shown."),
    severity=Severity.WARNING,
)
SHUTTING_DOWN = Fault("storage.shutting_down", remedies.WAIT_FOR_PART)
CHANGED = Fault(
    "storage.changed",
    Message("Make sure that no other program writes into the survey's folder, then try again."),
)

# Why a survey ended without its client.
SHUT_DOWN = Fault("survey.shut_down", remedies.RESUME_SURVEY, severity=Severity.NOTE)
LEFT_OPEN = Fault("survey.left_open", remedies.RESUME_SURVEY, severity=Severity.NOTE)
