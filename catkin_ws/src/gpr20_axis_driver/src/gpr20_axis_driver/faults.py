"""The faults of an axis; those by which other packages decide are in `gpr20_survey.faults`."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

_SET_ZERO = Message("Turn the antennas to their mark and set the zero of the axis on ROBOT.")
_LESS_LOAD_AND_HOME = Message(
    "End other programs on the robot's computer, and check that it is not hot. Then home the axis."
)
_HOME_OR_RESTART = Message(
    "Home the axis. If it happens again, switch the robot off and on and keep the log."
)
_CHECK_CONTROLLER = Message(
    "Keep your hands clear: the axis may still move. Check the power and the cable of its "
    "controller, then home the axis."
)

FAILED = Fault("axis.failed", _HOME_OR_RESTART)
STOPPED = Fault("axis.stopped", Message("Nothing to do: somebody ended the motion."), Severity.NOTE)
BUSY = Fault("axis.busy", Message("Wait until the axis is at rest, or press STOP. Then try again."))
OWNED = Fault(
    "axis.owned",
    Message("Wait until the survey or the service has ended, or press STOP. Then try again."),
)
NOT_BEGUN = Fault(
    "axis.not_begun", Message("Wait until the axis is at rest, then request the motion again.")
)
OUTSIDE_TRAVEL = Fault("axis.outside_travel", remedies.CORRECT_VALUE)

ENDSTOP_NOT_REACHED = Fault(
    "axis.endstop_not_reached",
    Message(
        "Check that the motors have power. Then switch it off and check the endstop switch, its "
        "cable and the motor's cable. Switch the power on again and home the axis."
    ),
)
ENDSTOP_STUCK = Fault("axis.endstop_stuck", remedies.CHECK_ENDSTOP)
ENDSTOP_INACCURATE = Fault("axis.endstop_inaccurate", remedies.CHECK_ENDSTOP)
ENDSTOP_PRESSED = Fault("axis.endstop_pressed", remedies.CHECK_ENDSTOP)
ENDSTOP_SETS_ZERO = Fault("axis.endstop_sets_zero", remedies.HOME_AXIS)

POSITION_LOST = Fault("axis.position_lost", remedies.HOME_AXIS)
ZERO_UNKNOWN = Fault("axis.zero_unknown", _SET_ZERO)

PULSE_LATE = Fault("axis.pulse_late", _LESS_LOAD_AND_HOME)
PULSES_STALLED = Fault("axis.pulses_stalled", _LESS_LOAD_AND_HOME)
PULSES_SLOWED = Fault("axis.pulses_slowed", remedies.LESS_LOAD, Severity.WARNING)
PULSES_NOT_READY = Fault("axis.pulses_not_ready", remedies.LESS_LOAD)
PULSES_ENDED = Fault("axis.pulses_ended", _HOME_OR_RESTART)
PINS_NOT_LOW = Fault(
    "axis.pins_not_low",
    Message(
        "Switch off the motors' power now and keep your hands clear. Switch the robot off and on, "
        "then the motors' power on, and home the axis."
    ),
    may_move=True,
)
DRIVER_HUNG = Fault("axis.driver_hung", remedies.LESS_LOAD)
NO_REALTIME = Fault(
    "axis.no_realtime",
    Message(
        "Ask the person who maintains the robot to allow real-time scheduling (rtprio and memlock "
        "in /etc/security/limits.d)."
    ),
    Severity.WARNING,
)

CONTROLLER_FAILED = Fault("axis.controller_failed", _CHECK_CONTROLLER, may_move=True)
CONTROLLER_SILENT = Fault("axis.controller_silent", _CHECK_CONTROLLER, may_move=True)
MOTION_NOT_ENDED = Fault(
    "axis.motion_not_ended",
    Message(
        "Keep your hands clear: the axis may still move. Switch off the motors' power and check "
        "the motor and the endstop, then home the axis."
    ),
    may_move=True,
)

NO_PIN_LIBRARY = Fault("axis.no_pin_library", remedies.INSTALL_ROBOT)
PIGPIO_FAILED = Fault(
    "axis.pigpio_failed",
    Message(
        "Ask the person who maintains the robot to check that the daemon pigpiod runs. Then home "
        "the axis."
    ),
)
PIGPIO_TAKEN = Fault("axis.pigpio_taken", remedies.CHECK_CONFIGURATION)
NO_AXIS_NAME = Fault("axis.no_name", remedies.CHECK_CONFIGURATION)
# A full disk, which the sentence names, is a matter of the disk.
STEP_COUNT_NOT_STORED = Fault("axis.step_count_not_stored", remedies.CHECK_CONFIGURATION)
STEP_COUNT_UNKNOWN = Fault(
    "axis.step_count_unknown",
    Message(
        "Ask the person who maintains the robot to move the file away that the message names. Then "
        "turn the antennas to their mark and set the zero of the axis."
    ),
)
DRIVEN_BY_OTHER = Fault(
    "axis.driven_by_other",
    Message("End the other program that drives this axis, or switch the robot off and on."),
)
