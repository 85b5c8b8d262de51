"""The faults of a launch and of the robot's configuration."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

WRONG_VALUE = Fault(
    "config.wrong_value",
    Message("Correct the file that the message names, then launch the robot again."),
    replaces=True,
)
UNREADABLE = Fault(
    "config.unreadable",
    Message("Check that the file that the message names is there and that this user may read it."),
    replaces=True,
)
UNKNOWN_FILE = Fault(
    "config.unknown_file",
    Message("Give the file one of the names that are allowed, or move it to another folder."),
)
NO_FOLDER = Fault(
    "config.no_folder",
    Message("Correct the folder after config:=, or create it with robot_config create."),
)
UNUSABLE_EXTENSION = Fault(
    "config.unusable_extension",
    Message(
        "Install the package of the class that the message names, or correct its name and options "
        "in the configuration."
    ),
    replaces=True,
)
UNCHECKED_ANALYZER = Fault(
    "config.unchecked_analyzer",
    Message("Before the next survey run: rosrun gpr20_vna_acquisition check_analyzer"),
    Severity.WARNING,
)
WRONG_ARGUMENT = Fault(
    "launch.wrong_argument",
    Message("Correct the argument that the message names, and launch the robot again."),
)
ROBOT_RUNNING = Fault(
    "launch.robot_running",
    Message("End the robot that is running, as the message says, then launch this one."),
)
