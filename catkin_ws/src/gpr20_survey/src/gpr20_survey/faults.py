"""The faults of surveys and their files, and those of devices that several packages report.

As in `gpr20_common.faults`, one code has one remedy.
"""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

# Plan and request.
PLAN_NOT_ALLOWED = Fault("plan.not_allowed", Message("Correct the value in the plan."))
NO_PLAN = Fault(
    "survey.no_plan", Message("Look at the plan on SURVEY, then start the survey again.")
)
UNKNOWN_SURVEY = Fault(
    "survey.unknown", Message("Check the name, and choose what the list in SURVEYS shows.")
)
NONE_OPEN = Fault(
    "survey.none_open",
    Message("Start a survey, or resume one: in SURVEYS, or by the name of its folder."),
)
TAKES_LONG = Fault(
    "survey.takes_long",
    Message("Wait: what takes long continues by itself. STOP ends it at any time."),
    Severity.WARNING,
)
CLOCK_WRONG = Fault(
    "clock.wrong",
    Message("Set the clock of the robot's computer, but not during a survey."),
)
MARKER_REFUSED = Fault("marker.refused", Message("Look at the markers on Ground, then try again."))
CHECK_ORDER = Fault(
    "service.check_order", Message("Begin the daily check again, with the empty sweep.")
)

# A survey that is interrupted, and its files.
CAN_RESUME = Fault(
    "survey.can_resume",
    Message("Resume the survey: that checks and repairs what is stored, and measures the rest."),
)
STOPPED = CAN_RESUME.as_note()
COMPLETE = Fault(
    "survey.complete",
    Message("Plan a new survey: this one cannot be continued."),
    Severity.NOTE,
    can_continue=False,
)
DAMAGED = Fault(
    "survey.damaged",
    Message("Keep the survey's folder as it is and let an analyst check it with gpr20 verify."),
)
LOG_LOST = Fault(
    "survey.log_lost",
    Message(
        "Copy the survey's folder first. Then put log.jsonl and log.copy.jsonl back from an older "
        "copy; without one, let an analyst check the folder."
    ),
    can_continue=False,
)
MANIFEST_DAMAGED = Fault(
    "survey.manifest_damaged",
    Message(
        "Let an analyst check the survey's folder with gpr20 verify, then with its option --repair."
    ),
)
OTHER_VERSION = Fault(
    "survey.other_version",
    Message(
        "Keep the survey's folder. Read it with the version of the software that recorded it, or "
        "a later one."
    ),
)
UNCONFIRMED = Fault(
    "survey.unconfirmed",
    Message("Compare the survey's parameters with what you planned before you use its traces."),
    Severity.WARNING,
)
NOT_SIGNED = Fault(
    "survey.not_signed",
    Message(
        "Keep the survey: it is stored. Ask the person who maintains the robot to correct or "
        "make the signing key (rosrun gpr20_launch robot_config key) and to sign the survey with "
        "gpr20 sign."
    ),
    Severity.WARNING,
)
LOCKED = Fault(
    "survey.locked",
    Message("Let the other program end, or stop its survey; end the program only if it hangs."),
)
CLOSING = Fault(
    "survey.closing", Message("Press STOP again: the survey's recordings are not finished yet.")
)
BAG_MISSING = Fault(
    "storage.bag_missing",
    Message("Make space if the disk is full, then make the bag with the command that is shown."),
    Severity.WARNING,
)
FOLDER_MOVED = Fault(
    "storage.folder_moved",
    Message("Put the survey's folder back to its place and name, then resume the survey."),
)
FILE_EXISTS = Fault(
    "storage.file_exists",
    Message("Move away the file that the message names, then try again."),
)
NO_DATA_DISK = Fault(
    "storage.no_data_disk",
    Message(
        "Plug in and mount the disk of the surveys, then try again. A robot without one has no "
        "data_disk in storage.yaml."
    ),
)
OTHER_DATA_FOLDER = Fault(
    "storage.other_data_folder",
    Message(
        "Plug in and mount the disk of the surveys, then try again. Only if the folder is to be "
        "used from now on, the person who maintains the robot accepts it as the user who runs the "
        "robot: rosrun gpr20_launch robot_config accept_data"
    ),
)
FILE_SYSTEM_UNSUITABLE = Fault(
    "storage.file_system_unsuitable",
    Message("Use another disk with ext4 for the surveys. To format this one deletes all on it."),
)

# The axes. A survey waits for a control that is silent, and the window asks about other zeros.
NOT_HOMED = Fault(
    "axis.not_homed",
    Message("Home the axis on ROBOT; a survey that is started or resumed homes it too."),
)
ZERO_UNKNOWN = Fault(
    "axis.zero_unknown",
    Message("Turn the antennas to their mark and set the zero of the axis on ROBOT."),
)
ENDSTOP = Fault(
    "axis.endstop",
    Message(
        "Switch off the motors' power. Look for anything that blocks the carriage, and check the "
        "endstop switch, the cables and the belt. Switch the power on again and home the axis."
    ),
)
AXIS_MAY_MOVE = Fault(
    "axis.may_move",
    Message(
        "Keep your hands clear: the axis may still move. Switch off the motors' power, check the "
        "carriage, the motor, its cables and its controller, then home the axis."
    ),
    may_move=True,
)
CONTROL_SILENT = Fault(
    "axis.control_silent",
    Message(
        "Wait one minute: a survey continues by itself. If it does not, or if this happens again, "
        "end other programs on the server, and check the network cable between it and the robot."
    ),
)
OTHER_ZEROS = Fault(
    "survey.other_zeros",
    Message(
        "Check that the antennas stand at their mark at 0 deg, and that no belt or switch has "
        "moved. Then stop the survey and resume it, which compares again; or resume it as it is: "
        "its traces since then are marked."
    ),
)

# The height and other sensors.
HEIGHT_NOT_MEASURED = Fault(
    "height.not_measured", Message("A survey measures it; or measure it on ROBOT."), Severity.NOTE
)
NO_GROUND = Fault(
    "height.no_ground",
    Message(
        "Check the height of the antennas, the plug of the height sensor and what is below it. Do "
        "not touch grass, objects or ground that is not cleared."
    ),
)
SENSOR_FAILED = Fault(
    "sensor.failed",
    Message("Check the sensor that the message names: its place, its plug, its cable and supply."),
)

# The VNA.
VNA_SILENT = Fault(
    "vna.no_answer",
    Message("Check that the VNA is switched on and that its cable is plugged in at both ends."),
)
VNA_FAILED = Fault(
    "vna.failed",
    Message(
        "Look at the VNA's display. If it looks wrong, switch the VNA off and on and wait until it "
        "has started."
    ),
)
VNA_SETTINGS = Fault(
    "vna.settings",
    Message(
        "Set the VNA to VNA mode and a linear sweep, without smoothing and trace math. Do not "
        "touch its keys during a survey."
    ),
)
VNA_DOUBTFUL = Fault(
    "vna.doubtful",
    Message("Check what the message names, on the VNA's display and at its cables."),
    Severity.WARNING,
)
VNA_REPLACED = Fault(
    "vna.replaced",
    Message(
        "Connect the VNA with which the survey began. Or resume the survey, and accept the other "
        "VNA when you are asked."
    ),
)
WRONG_VNA = Fault(
    "vna.wrong_instrument",
    Message("Check that the right VNA is connected, and its address in the plan."),
)
NOT_CALIBRATED = Fault(
    "vna.not_calibrated", Message("Calibrate the VNA with the cables of the antennas.")
)
