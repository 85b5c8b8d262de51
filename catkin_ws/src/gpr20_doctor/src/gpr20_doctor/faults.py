"""What the doctor itself can report as a fault."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

CANNOT_WORK = Fault(
    "doctor.cannot_work",
    Message("Remove the reason that the message names, then run gpr20 doctor again."),
)
NO_VNA_RESULT = Fault("doctor.no_vna_result", remedies.CHECK_VNA_CABLE)
CALIBRATION_UNKNOWN = Fault(
    "vna.calibration_unknown", Message("Make sure that the VNA is calibrated."), Severity.WARNING
)
IDENTITY_WRONG = Fault("vna.not_of_this_robot", Message("Check the address of the VNA."))
NO_MASTER = Fault("doctor.no_master", remedies.START_ROBOT)
ENDSTOP_CLOSED = Fault("doctor.endstop_closed", remedies.CHECK_ENDSTOP)
ENDSTOP_DOUBTFUL = Fault(
    "doctor.endstop_doubtful",
    Message("See whether the carriage presses it. If not, check switch and cable."),
    Severity.WARNING,
)
HEIGHT_UNUSUAL = Fault(
    "height.unusual",
    Message("Look below the sensor, and check the offset in height.yaml."),
    Severity.WARNING,
)
CLOCKS_DIFFER = Fault(
    "clock.computers_differ",
    Message("Set the clocks of both computers, for example with chrony."),
    Severity.WARNING,
)
DISK_TOO_SLOW = Fault("doctor.disk_too_slow", Message("Use a faster disk or SD card (data:=)."))
