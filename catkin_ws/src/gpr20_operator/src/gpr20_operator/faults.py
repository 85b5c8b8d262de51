"""What can go wrong in the window and the terminal client, for programs."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

# The contact with the robot.
NO_MASTER = Fault("window.no_master", remedies.START_ROBOT)
MASTER_LOST = Fault(
    "window.master_lost",
    Message(
        "If people are near the robot, switch off the motors' power. Then check the robot's "
        "software and the cable between the computers."
    ),
    may_move=True,
)
NO_CONTROL = Fault(
    "window.no_control",
    Message(
        "Start the robot with roslaunch gpr20 survey.launch. If it runs, check ROS_MASTER_URI and "
        "the namespace."
    ),
)
CONTROL_LOST = Fault(
    "window.control_lost",
    Message(
        "If people are near the robot, switch off the motors' power. Then wait one minute: the "
        "robot restarts the part by itself."
    ),
    may_move=True,
)
CONTROL_RESTARTED = Fault(
    "window.control_restarted",
    Message("Keep your hands clear: the axes may still move. When they rest, resume the survey."),
    may_move=True,
)
INTERRUPTED = Fault(
    "window.interrupted",
    Message("Resume the survey on SURVEY, or plan another one."),
)
CONTROL_LATE = Fault(
    "window.control_late",
    Message("Wait some seconds. STOP stops every axis at any time."),
    Severity.WARNING,
)
PART_SILENT = Fault("window.part_silent", remedies.WAIT_FOR_PART)
STANDS_STILL = Fault(
    "window.stands_still",
    Message(
        "Look on ROBOT for a part with a fault. If there is none, press PAUSE and resume; STOP "
        "ends the survey, and what is stored is kept."
    ),
    Severity.WARNING,
)
STOP_UNCONFIRMED = Fault("window.stop_unconfirmed", remedies.MOTORS_OFF, may_move=True)
ROBOT_MOVES = Fault(
    "window.robot_moves",
    Message("Keep your hands clear. STOP stops every axis, whoever moves it."),
    Severity.WARNING,
    may_move=True,
)
NOT_STARTED = Fault(
    "window.not_started",
    Message("Nothing to do: nothing was started. Run the command again to start a survey."),
    Severity.NOTE,
)
NO_SURVEY = Fault("window.no_survey", remedies.NOTHING_TO_DO, Severity.NOTE)
REPLAY_BESIDE = Fault(
    "window.replay_beside",
    Message(
        "End the program that the details name. Play recordings away from the robot's topics, with "
        "the prefix /replay."
    ),
    Severity.WARNING,
)
REPLAY_RUNS = Fault(
    "window.replay_runs", Message("End the replay and start the robot, or follow with --attach.")
)
LIMITS_UNKNOWN = Fault("window.limits_unknown", remedies.SAME_VERSION)
NO_DISPLAY = Fault(
    "window.no_display",
    Message("Log in on the screen and set DISPLAY to it, or launch with ui:=false."),
)

# Values that people enter, and files of the window.
PARAMETERS_REFUSED = Fault("window.parameters_refused", remedies.CORRECT_VALUE)
PROFILE_NAME = Fault("window.profile_name", remedies.CORRECT_VALUE)
PROFILE_UNREADABLE = Fault(
    "window.profile_unreadable",
    Message("Enter the values by hand and save the profile again."),
)
PROFILE_NOT_STORED = Fault("window.profile_not_stored", remedies.CHECK_DISK)
SETTINGS_DAMAGED = Fault(
    "window.settings_damaged",
    Message("Check the values on the screen before you use them: they are the defaults."),
    Severity.WARNING,
)
SETTINGS_NOT_STORED = Fault("window.settings_not_stored", remedies.CHECK_DISK)

# What is shown of a survey.
SURVEY_UNREADABLE = Fault("window.survey_unreadable", remedies.KEEP_SURVEY)
PLAN_UNREADABLE = Fault("window.plan_unreadable", remedies.KEEP_SURVEY)
COVERAGE_WRONG = Fault("window.coverage_wrong", remedies.SAME_VERSION)
