"""The faults that every package can report."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

INTERNAL = Fault("robot.internal_error", remedies.RESTART_ROBOT)
CONFIGURATION = Fault("config.value_not_allowed", remedies.CHECK_CONFIGURATION)
NOT_ALLOWED = Fault("value.not_allowed", remedies.CORRECT_VALUE)
FILE_DAMAGED = Fault(
    "file.damaged",
    Message(
        "Ask the person who maintains the robot to correct the file that the message names, or to "
        "put back a copy of it that worked."
    ),
)
TRANSLATION_UNREADABLE = Fault(
    "language.unreadable",
    Message(
        "Choose another language, and ask the person who maintains the robot to correct or remove "
        "the file that the message names."
    ),
)
EXTENSION_UNUSABLE = Fault("config.extension_unusable", remedies.CHECK_CONFIGURATION)
PRIVATE_PARAMETERS = Fault("config.private_parameters", remedies.CHECK_CONFIGURATION)
CONFIGURATION_GONE = Fault("launch.configuration_gone", remedies.RESTART_ROBOT)
SOFTWARE_DIFFERS = Fault("node.software_differs", remedies.SAME_VERSION, Severity.WARNING)
SERVICE_UNAVAILABLE = Fault("service.unavailable", remedies.WAIT_FOR_PART)
SERVICE_SILENT = Fault("service.silent", remedies.WAIT_FOR_PART)
NODE_SILENT = Fault("node.silent", remedies.WAIT_FOR_PART)
NODE_GONE = Fault("node.gone", remedies.WAIT_FOR_PART)
DISK_FULL = Fault("disk.full", remedies.MAKE_SPACE)
DISK_REFUSES = Fault("disk.refuses", remedies.CHECK_DISK)
