"""The faults of surveys and their files, and those of devices by which other packages decide."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

# Plan and configuration.
PLAN_NOT_ALLOWED = Fault("plan.not_allowed", remedies.CORRECT_PLAN)
OTHER_PARAMETERS = Fault("node.other_parameters", remedies.SAME_VERSION)
MIXED_PARTS = Fault("launch.mixed_parts", Message("End every launch of the robot, then start one."))
CLOCK_WRONG = Fault("clock.wrong", remedies.SET_CLOCK)

# A trace that is measured.
WRONG_SWEEP = Fault("vna.wrong_sweep", remedies.CHECK_VNA)
SENSOR_NOT_FINITE = Fault(
    "sensor.not_finite", Message("Check the sensor that the message names, and its plug.")
)
TRACE_NOT_ALLOWED = Fault("trace.not_allowed", remedies.REPORT)

# What is stored of a survey.
TRACE_DAMAGED = Fault("trace.damaged", remedies.KEEP_SURVEY)
TRACE_OTHER_VERSION = Fault(
    "trace.other_version",
    Message(
        "Keep the survey's folder. Read it with the version of the software that recorded it, or "
        "a later one."
    ),
)
DESCRIPTION_DAMAGED = Fault("survey.description_damaged", remedies.RESUME_SURVEY)
DESCRIPTION_LOST = Fault(
    "survey.description_lost",
    Message(
        "Keep the survey's folder as it is. Put log.jsonl back from a copy of it; without a "
        "copy, let an analyst check the folder."
    ),
    can_continue=False,
)
DESCRIPTION_UNREADABLE = Fault("survey.unreadable", remedies.KEEP_SURVEY)
MANIFEST_DAMAGED = Fault(
    "survey.manifest_damaged",
    Message(
        "Let an analyst check the survey's folder with gpr20 verify, then write the manifest "
        "again with gpr20 repair."
    ),
)
REPAIRED = Fault("survey.repaired", remedies.KEEP_SURVEY, severity=Severity.WARNING)
UNCONFIRMED = Fault(
    "survey.unconfirmed",
    Message("Compare the survey's parameters with what you planned before you use its traces."),
    severity=Severity.WARNING,
)

# Requests.
REQUEST_REFUSED = Fault("storage.request_refused", remedies.CORRECT_VALUE)
UNKNOWN_SURVEY = Fault("survey.unknown", remedies.OTHER_NAME)
MARKER_REFUSED = Fault("marker.refused", Message("Look at the markers on Ground, then try again."))

# Files and the disk.
NOT_PERMITTED = Fault(
    "storage.not_permitted",
    Message(
        "Ask the person who maintains the robot to check to whom the data folder belongs, and "
        "its disk."
    ),
)
FILE_EXISTS = Fault(
    "storage.file_exists",
    Message("Move the file that the message names out of the survey's folder, then try again."),
)
NOT_A_FILE = Fault(
    "storage.not_a_file",
    Message(
        "Ask the person who maintains the robot to move away what the message names, and to put "
        "the file itself there."
    ),
)
FOLDER_MOVED = Fault(
    "storage.folder_moved",
    Message("Put the survey's folder back to its place and name, then resume the survey."),
)
OTHER_DATA_FOLDER = Fault(
    "storage.other_data_folder",
    Message(
        "Plug in and mount the disk of the surveys, then try again. Only if the folder is to be "
        "used from now on, the person who maintains the robot accepts it as the user who runs the "
        "robot: rosrun gpr20_launch robot_config accept_data"
    ),
)
NO_DATA_DISK = Fault(
    "storage.no_data_disk",
    Message(
        "Plug in and mount the disk of the surveys, then try again. A robot without one has no "
        "data_disk in storage.yaml."
    ),
)
FILE_SYSTEM_UNSUITABLE = Fault(
    "storage.file_system_unsuitable",
    Message("Use another disk for the surveys, or format it with ext4, which deletes all on it."),
)
LOCKED = Fault(
    "survey.locked", Message("Another program writes this survey: end the survey there first.")
)

# The signature of a survey: without it a survey is whole, but nobody vouches for it.
NOT_SIGNED = Fault(
    "survey.not_signed",
    Message(
        "Keep the survey: it is stored. Ask the person who maintains the robot to look at the "
        "signing key, and to sign the survey with gpr20 sign."
    ),
    Severity.WARNING,
)
SIGNING_KEY = Fault(
    "survey.signing_key",
    Message(
        "Correct the file of the key as the message says, or move it away and make another key "
        "with rosrun gpr20_launch robot_config key. Then sign the survey with gpr20 sign."
    ),
    Severity.WARNING,
)

# The calibration of the VNA: its driver and the doctor report it.
_CALIBRATE = Message("Calibrate the VNA with the cables of the antennas.")
NOT_CALIBRATED = Fault("vna.not_calibrated", _CALIBRATE)
CALIBRATION_AGED = Fault("vna.calibration_aged", _CALIBRATE, Severity.WARNING)

# The main control lets a survey wait and continue: nobody asked for these stops.
CONTROL_SILENT = Fault(
    "axis.control_silent",
    Message(
        "Wait one minute: a survey continues by itself. If it does not, or if this happens again, "
        "end other programs on the server, and check the network cable between it and the robot."
    ),
)
CHECK_ORDER = Fault(
    "service.check_order", Message("Begin the daily check again, with the empty sweep.")
)
# The window asks the operator about it.
OTHER_ZEROS = Fault(
    "survey.other_zeros",
    Message(
        "Check that the antennas stand at their mark at 0 deg, and that no belt or switch has "
        "moved. Then stop the survey and resume it, which compares again; or resume it as it is: "
        "its traces since then are marked."
    ),
)
# The doctor only notes these two: a survey homes and measures by itself.
NOT_HOMED = Fault("axis.not_homed", remedies.HOME_AXIS)
HEIGHT_NOT_MEASURED = Fault(
    "height.not_measured", Message("A survey measures it; or measure it on ROBOT."), Severity.NOTE
)
FOLDER_CHANGED = Fault(
    "storage.folder_changed", Message("Wait until the survey has ended, then export it.")
)
