"""The faults that several packages report, each with what a person does first about it.

A remedy is one or two sentences for somebody who stands beside the robot. What a person or a
program has to do differently is another code; so one code has one remedy, and the sentence that
reports it names the part, the file or the value.
"""

from __future__ import annotations

from gpr20_common.message import MOTORS_OFF, Fault, Message, Severity

# The robot and its parts.
INTERNAL = Fault(
    "robot.internal_error",
    Message(
        "Switch the robot off and on. If it happens again, keep the log and report it to the "
        "programmers."
    ),
)
PART_SILENT = Fault(
    "robot.part_silent",
    Message(
        "Wait one minute: the robot restarts the part by itself. If it is still red on ROBOT, "
        "switch the robot off and on."
    ),
)
PART_LOST = Fault(
    "robot.part_lost",
    Message(
        "Keep your hands clear: the axes may still move. Wait one minute: the robot restarts the "
        "part by itself. If it does not, switch off the motors' power, then switch the robot off "
        "and on."
    ),
    may_move=True,
)
LOOK = Message("Open ROBOT on the screen, and press the name of the part that is red.")
PART_RED = Fault("robot.part_red", LOOK)
MAY_MOVE = Fault("robot.may_move", MOTORS_OFF, may_move=True)
NOT_RUNNING = Fault(
    "robot.not_running",
    Message(
        "Start the robot's software and, with two computers, check the cable between them. If it "
        "runs, check ROS_MASTER_URI and the namespace."
    ),
)
OTHER_LAUNCH = Fault(
    "robot.other_launch", Message("End every launch of the robot, then start one.")
)
VERSIONS_DIFFER = Fault(
    "robot.versions_differ",
    Message(
        "Ask the person who maintains the robot to install the same version on all its computers."
    ),
)
OVERLOADED = Fault(
    "robot.overloaded",
    Message("End other programs on the robot's computer, and check that it is not hot."),
)
IN_USE = Fault("robot.in_use", Message("Wait until what is in progress has ended, or press STOP."))
BUSY = Fault("robot.busy", Message("Wait one minute, then try again."))
ASKED_FOR = Fault("robot.asked_for", Message("Nothing to do: it has ended."), Severity.NOTE)

# Configuration, values and the computer.
CONFIGURATION = Fault(
    "config.wrong",
    Message(
        "Ask the person who maintains the robot to correct what the message names, then start "
        "the robot again."
    ),
)
NOT_ALLOWED = Fault(
    "value.not_allowed", Message("Correct the value that the message names, then try again.")
)
NOT_SET_UP = Fault(
    "computer.not_set_up",
    Message(
        "Ask the person who maintains the robot to set up what the message names, with "
        "scripts/setup.sh --robot or as docs/install.md says. On another computer, launch with "
        "robot:=simulated."
    ),
)
FILE_DAMAGED = Fault(
    "file.damaged",
    Message(
        "Ask the person who maintains the robot to correct the file that the message names, or to "
        "put back a copy of it that worked."
    ),
)
DISK_FULL = Fault(
    "disk.full",
    Message("Copy old surveys to a USB stick, check the copies, then delete the originals."),
)
DISK_REFUSES = Fault(
    "disk.refuses",
    Message(
        "Check that the disk is plugged in, not full and not write-protected, and that the user "
        "may read and write there."
    ),
)
DISK_SLOW = Fault(
    "disk.slow",
    Message("Check plug and space of the disk. End what else uses it, or use a faster disk."),
)
