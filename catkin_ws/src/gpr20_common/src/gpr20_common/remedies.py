"""What to do first about faults of more than one kind; the faults of one package have their own.

A remedy is one or two sentences for somebody who stands beside the robot.
"""

from __future__ import annotations

from gpr20_common.message import MOTORS_OFF as MOTORS_OFF
from gpr20_common.message import Message

HOME_AXIS = Message("Home the axis on ROBOT; a survey that is started or resumed homes it too.")
CHECK_ENDSTOP = Message(
    "Switch off the motors' power. Look for anything that blocks the carriage, and check the "
    "endstop switch, its cable and the belt. Switch the power on again and home the axis."
)
START_ROBOT = Message(
    "Start the robot's software and, with two computers, check the cable between them. If it "
    "runs, check ROS_MASTER_URI."
)
INSTALL_ROBOT = Message(
    "Ask the person who maintains the robot to run scripts/setup.sh --robot. On another computer, "
    "launch with robot:=simulated."
)
MAKE_SPACE = Message("Make space on the disk: copy old surveys to a USB stick and delete them.")
CHECK_DISK = Message("Check that the disk is plugged in, not full and not write-protected.")
LESS_LOAD = Message("End other programs on the robot's computer, and check that it is not hot.")
WAIT_FOR_PART = Message(
    "Wait one minute: the robot restarts the part by itself. If it is still red on ROBOT, "
    "switch the robot off and on."
)
RESTART_ROBOT = Message("Switch the robot off and on. If it happens again, keep the log.")
TRY_LATER = Message("Wait one minute, then try again.")
CHECK_VNA = Message(
    "Look at the VNA's display. If it looks wrong, switch the VNA off and on and wait until it "
    "has started."
)
SAME_VNA = Message("Connect the VNA with which the survey began, or accept the other one.")
HANDS_OFF_VNA = Message("Set the VNA to VNA mode. Do not touch its keys during a survey.")
CHECK_VNA_CABLE = Message(
    "Check that the VNA is switched on and that its network cable is plugged in at both ends."
)
SET_CLOCK = Message("Set the clock of the robot's computer.")
OTHER_SURVEY = Message("Wait until the survey that is in progress has ended, or press STOP.")
NOTHING_TO_DO = Message("Nothing to do: no survey is in progress.")
RESUME_SURVEY = Message("Resume the survey: that checks and repairs what is stored.")
NEW_SURVEY = Message("Plan a new survey: this one cannot be continued.")
KEEP_SURVEY = Message(
    "Keep the survey's folder as it is and let an analyst check it with gpr20 verify."
)
OTHER_NAME = Message("Check the name, and choose what the list in ARCHIVE shows.")
CORRECT_PLAN = Message("Correct the value in the plan.")
CORRECT_VALUE = Message("Correct the value that the message names.")
CHECK_CONFIGURATION = Message("Ask the person who maintains the robot to check its configuration.")
SAME_VERSION = Message(
    "Ask the person who maintains the robot to install the same version on all its computers."
)
REPORT = Message(
    "Keep the log and report this to the programmers. Check that all programs of the robot have "
    "the same version."
)
CHECK_STATUS = Message("Look on ROBOT for the part that is red, and touch it.")
