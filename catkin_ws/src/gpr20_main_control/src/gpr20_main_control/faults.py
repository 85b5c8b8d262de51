"""The faults of a survey and of maintenance, and what to do first about each."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

_CHECK_AXIS = Message(
    "Keep your hands clear. Look for anything that blocks the carriage or holds a cable, and "
    "check the motors' power."
)
_CLEAR_AXIS = Message(
    "Look for anything that blocks or touches the axis, and for whoever stopped it. When the axis "
    "is clear, resume the survey, or try again on ROBOT."
)
_FORMER_LAUNCH = Message(
    "End every launch, start the robot with the configuration that the survey began with, and "
    "resume the survey."
)
_CHOOSE_VNA = Message("Look which VNA is connected, resume the survey and choose again.")
_HOME_AXIS = Message("Home the axis on ROBOT.")
_KEEP_AND_PLAN = Message("Keep the survey's folder as it is for an analyst, and plan a new survey.")
_RESUME_AND_HOME = Message(
    "Resume the survey: it homes the axis first. Without a survey, home the axis on ROBOT."
)

SURVEY_FAILED = Fault("survey.failed", remedies.CHECK_STATUS)
DEVICE_FAILED = Fault("survey.device_failed", remedies.CHECK_STATUS)
NODE_LOST = Fault("survey.part_lost", remedies.WAIT_FOR_PART)
NODE_NOT_BACK = Fault(
    "survey.part_not_back",
    Message(
        "Look on ROBOT which part is red, and check its power and its cables. If it stays "
        "red, switch the robot off and on."
    ),
)
NODE_LOST_OFTEN = Fault("survey.part_lost_often", remedies.RESTART_ROBOT)
WAITING_FOR_PART = Fault("survey.waiting_for_part", remedies.WAIT_FOR_PART, Severity.WARNING)
TAKES_LONG = Fault(
    "survey.takes_long",
    Message("Wait until the time that is shown: the survey continues by itself."),
    Severity.WARNING,
)

# Requests that are not possible now.
SURVEY_IN_PROGRESS = Fault("survey.in_progress", remedies.OTHER_SURVEY)
OTHER_PAUSED = Fault(
    "survey.other_paused",
    Message("Resume the paused survey, or press STOP; then resume the other one."),
)
BUSY = Fault("survey.busy", remedies.TRY_LATER)
NO_PLAN = Fault("survey.no_plan", Message("Enter the plan on SURVEY, then start the survey."))
OTHER_PLAN = Fault(
    "survey.other_plan", Message("Look at the plan on SURVEY, then start the survey again.")
)
NONE_RUNNING = Fault("survey.none_running", remedies.NOTHING_TO_DO, Severity.NOTE)
NONE_MEASURING = Fault(
    "survey.none_measuring",
    Message("Nothing to do: no survey is measuring. STOP ends a survey at any time."),
    Severity.NOTE,
)
NONE_PAUSED = Fault("survey.none_paused", Message("Choose the survey to resume in ARCHIVE."))
PAUSED_ON_REQUEST = Fault(
    "survey.paused_on_request", Message("Resume the survey, or stop it."), Severity.NOTE
)
STOPPED_ON_REQUEST = Fault(
    "survey.stopped_on_request",
    Message("Nothing to do. The survey can be resumed in ARCHIVE."),
    Severity.NOTE,
)
STOPPED_BEFORE = Fault(
    "survey.stopped_before",
    Message("If nobody is in danger, press START, RESUME or the service button again."),
    Severity.NOTE,
)
ROBOT_SHUT_DOWN = Fault(
    "survey.robot_shut_down",
    Message("Start the robot again, then resume the survey in ARCHIVE."),
    Severity.NOTE,
)

INCOMPLETE = Fault("survey.incomplete", remedies.RESUME_SURVEY)

# The survey and the robot do not fit each other.
RECORD_DAMAGED = Fault("survey.record_damaged", _KEEP_AND_PLAN, can_continue=False)
OTHER_ROBOT = Fault(
    "survey.other_robot",
    Message("Start the robot that measured the survey, or plan a new survey."),
    can_continue=False,
)
OTHER_AXES = Fault(
    "survey.other_axes",
    Message(
        "Start the robot with the former parameters of the axis, or plan a new survey: let the "
        "person who maintains the robot decide."
    ),
    can_continue=False,
)
CONFIGURATION_CHANGED = Fault("survey.configuration_changed", _FORMER_LAUNCH)
SENSOR_FIELD_MISSING = Fault("config.sensor_field_missing", remedies.CHECK_CONFIGURATION)
SENSOR_TYPE_UNKNOWN = Fault("config.sensor_type_unknown", remedies.CHECK_CONFIGURATION)
SENSOR_TYPE_DIFFERS = Fault("config.sensor_type_differs", remedies.CHECK_CONFIGURATION)
SENSORS_FILE = Fault("config.sensors_file", remedies.CHECK_CONFIGURATION)

# Axes.
AXIS_STILL_MOVING = Fault("axis.still_moving", remedies.MOTORS_OFF, may_move=True)
# In a motion, other than NODE_LOST: that it ended is likely, but nobody has confirmed it.
AXIS_SILENT = Fault(
    "survey.axis_silent",
    Message(
        "Keep your hands clear: the axis may still move. Wait one minute: the robot restarts the "
        "part by itself. If it is still red on ROBOT, switch off the motors' power, then "
        "switch the robot off and on."
    ),
    may_move=True,
)
MOVE_TOO_LONG = Fault("survey.move_too_long", _CHECK_AXIS, may_move=True)
MOVE_FAILED = Fault("survey.move_failed", _CLEAR_AXIS)
HOMING_FAILED = Fault("survey.homing_failed", _CLEAR_AXIS)
AXIS_NOT_HOMED = Fault("survey.axis_not_homed", _RESUME_AND_HOME)
AXIS_OFF_TARGET = Fault(
    "survey.axis_off_target",
    Message(
        "Look for anything that blocks the carriage or holds a cable. Then home the axis on "
        "ROBOT; a paused survey must be stopped before, and can be resumed afterwards."
    ),
)
ZERO_CHANGED = Fault(
    "survey.zero_changed",
    Message(
        "Let no person and no other program home the axes or set a zero. Resume the survey: it "
        "homes the axis itself where it can, and measures a known point again."
    ),
)
MOVED_BY_OTHERS = Fault(
    "survey.moved_by_others",
    Message("Let no person and no other program move the axes, then resume the survey."),
)

# Height, other sensors and the analyzer.
HEIGHT_NOT_MEASURED = Fault(
    "survey.height_not_measured",
    Message(
        "Check the plug of the height sensor. Remove grass or objects below it, so that it sees "
        "the ground."
    ),
)
SENSOR_NOT_MEASURED = Fault(
    "sensor.not_measured",
    Message("Check the plug and the cable of the sensor that is named, and that its node runs."),
)
SENSOR_IMPLAUSIBLE = Fault(
    "sensor.implausible",
    Message("Check the sensor that is named: its place, its plug and its cable."),
)
OTHER_SENSORS = Fault(
    "sensor.others_than_before",
    Message("Check that the sensors are those that the survey needs."),
    Severity.WARNING,
)
WRONG_VNA = Fault(
    "survey.wrong_vna",
    Message("Check the address of the VNA in the plan, and which VNA is connected."),
)
OTHER_VNA = Fault(
    "survey.other_vna",
    remedies.SAME_VNA,
)
NOT_THE_ACCEPTED_VNA = Fault("survey.not_accepted_vna", _CHOOSE_VNA)
VNA_SETTINGS_CHANGED = Fault(
    "survey.vna_settings_changed",
    remedies.HANDS_OFF_VNA,
)
VNA_SETTINGS_REFUSED = Fault(
    "survey.vna_settings_refused",
    Message(
        "Set the VNA to VNA mode and do not touch its keys. If it accepts other values again, "
        "correct the plan."
    ),
)
FREQUENCIES_CHANGED = Fault("survey.frequencies_changed", remedies.NEW_SURVEY, can_continue=False)
DRIFTED = Fault(
    "survey.drifted",
    Message(
        "Check that nothing was moved below the first stop, and the antenna cables and their "
        "connectors; let the VNA warm up. Resume the survey: it measures the first stop again and "
        "continues from there."
    ),
)
SWEEP_UNCONFIRMED = Fault("survey.sweep_unconfirmed", remedies.CHECK_VNA)
CONFIRMATION_LATE = Fault("survey.confirmation_late", remedies.LESS_LOAD)
VNA_SILENT = Fault(
    "survey.vna_silent",
    remedies.CHECK_VNA_CABLE,
)

# Storage and clock.
NOT_STORED = Fault("survey.trace_not_stored", remedies.CHECK_DISK)
NOT_FINISHED = Fault("survey.recordings_unfinished", remedies.RESUME_SURVEY)
CLOCK_SET = Fault(
    "clock.set_during_survey",
    Message(
        "Check that the clock of the robot's computer is right. Do not set it during a survey."
    ),
    Severity.WARNING,
)
CLOCK_BEHIND = Fault("clock.behind_last_trace", remedies.SET_CLOCK, Severity.WARNING)

# Maintenance.
SERVICE_IN_PROGRESS = Fault(
    "service.in_progress",
    Message("Wait until the service on this robot has ended, or press STOP."),
)
SERVICE_VALUE = Fault("service.value_not_allowed", remedies.CORRECT_VALUE)
SERVICE_HOME_FIRST = Fault("service.home_first", _HOME_AXIS)
SERVICE_SET_ZERO = Fault(
    "service.zero_unknown",
    Message("Turn the antennas to their mark and set the zero of the Z axis on ROBOT."),
)
SERVICE_STOPPED = Fault(
    "service.stopped", Message("Nothing to do: the axis is at rest."), Severity.NOTE
)
SERVICE_STOPPED_UNHOMED = Fault("service.stopped_not_homed", _HOME_AXIS, Severity.NOTE)
TEST_STOPPED = Fault(
    "service.test_stopped", Message("Nothing to do. Start the test again."), Severity.NOTE
)
SERVICE_MOVING = Fault(
    "service.axis_moving",
    Message("Wait until the axis is at rest, or press STOP."),
    may_move=True,
)
SERVICE_END_OF_RANGE = Fault(
    "service.end_of_range", Message("Correct the distance: move the axis the other way.")
)
