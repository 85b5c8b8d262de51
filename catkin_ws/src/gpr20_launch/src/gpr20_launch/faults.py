"""The faults of a launch and of the robot's configuration."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

WRONG_VALUE = Fault(
    "config.wrong_value",
    Message("Correct the file that the message names, then launch the robot again."),
)
UNREADABLE = Fault(
    "config.unreadable",
    Message("Check that the file that the message names is there and that this user may read it."),
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
PIN_CONFLICT = Fault(
    "config.pin_conflict",
    Message(
        "Find out with a continuity meter where the pin leads, as docs/wiring.md describes, and "
        "give each purpose a pin of its own."
    ),
)
PIN_UNUSABLE = Fault(
    "config.pin_unusable",
    Message("Connect the signal to a pin that is free, and write that into the file."),
)
TRAVEL = Fault(
    "config.travel",
    Message(
        "Measure how far the axis can move, and correct its travel: x and y in mm, z in degrees."
    ),
)
MOTION = Fault(
    "config.motion",
    Message("Correct step_size and the three pauses as docs/calibrate.md describes."),
)
ENDSTOP = Fault(
    "config.endstop",
    Message("Measure the signal of the endstop, pressed and free, and correct its keys."),
)
DATA_FOLDER = Fault(
    "config.data_folder",
    Message(
        "Correct what the message names (data:= of a launch counts before data: in storage.yaml, "
        "and that before GPR20_DATA), or mount the disk of the surveys."
    ),
)
DISK_RESERVE = Fault(
    "config.disk_reserve",
    Message("Make space on the disk of the surveys, or write a smaller disk_reserve_mb."),
)
ADDRESS = Fault("config.address", Message("Correct the address: each device has one of its own."))
SENSORS = Fault("config.sensors", Message("Correct sensors.yaml."))
SITE = Fault("config.site", Message("Correct site.yaml."))
LEFT_OVER_FILE = Fault(
    "config.left_over_file",
    Message(
        "Compare it with the file that is read, keep the right values there, and move it to "
        "another folder."
    ),
    Severity.WARNING,
)
NOT_CHECKED = Fault(
    "config.not_checked",
    Message(
        "Do what the message says, correct the files if necessary, then delete the word from "
        "wiring.yaml."
    ),
)
INPUT_VOLTAGE = Fault(
    "config.input_voltage",
    Message(
        "Supply the converter with 3.3 V, or put a level shifter between it and the Raspberry Pi: "
        "its inputs are made for 3.3 V."
    ),
)
OLD_LAUNCH = Fault(
    "config.old_launch",
    Message("Give the launch file of the original software that starts the nodes of the axes."),
)
OLD_UNREAD = Fault(
    "config.old_unread",
    Message("Look up what it sets on the original robot, and write the values of axes.yaml."),
)
FILES_EXIST = Fault(
    "config.files_exist",
    Message("Give an empty folder, compare its files with those, and copy what is right."),
)
