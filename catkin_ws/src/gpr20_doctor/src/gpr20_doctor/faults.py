"""What the doctor itself can report as a fault."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

CANNOT_WORK = Fault(
    "doctor.cannot_work",
    Message("Remove the reason that the message names, then run gpr20 doctor again."),
)
CONFIGURATION_REFUSED = Fault("doctor.configuration_refused", remedies.CHECK_CONFIGURATION)
PART_FAILED = Fault("node.failed", remedies.RESTART_ROBOT)
PART_WARNS = Fault(
    "node.warns", Message("Touch this part on ROBOT and read its details."), Severity.WARNING
)
VNA_UNREACHABLE = Fault("vna.unreachable", remedies.CHECK_VNA_CABLE)
VNA_TEST_FAILED = Fault("vna.test_failed", remedies.CHECK_VNA_CABLE)
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
COMPUTER_HOT = Fault("computer.hot", Message("Shade the computer and check its fan."))
VOLTAGE_LOW = Fault(
    "computer.voltage_low",
    Message("Charge the battery, and check the supply and its cable (5.1 V, 3 A)."),
)
CLOCK_NOT_FOLLOWED = Fault(
    "clock.not_followed",
    Message("Run: chronyc sources. Check the cable between the computers."),
    Severity.WARNING,
)
CLOCK_OFF = Fault(
    "clock.off",
    Message("Wait some minutes. If it stays, run: sudo chronyc makestep"),
    Severity.WARNING,
)
NETWORK_OPEN = Fault(
    "network.open",
    Message("Source setup.bash of the workspace, without ROS_IP and ROS_HOSTNAME set before."),
    Severity.WARNING,
)
ADDRESS_MISSING = Fault(
    "network.address_missing",
    Message("Check the link, GPR20_ROBOT and GPR20_SERVER, and source setup.bash again."),
)
ADDRESS_WRONG = Fault(
    "network.address_wrong",
    Message("Unset ROS_IP and ROS_HOSTNAME, and source setup.bash again."),
)
GROUP_MISSING = Fault(
    "computer.group_missing",
    Message("Run scripts/install_robot.sh, then restart the computer."),
    Severity.WARNING,
)
GROUP_AT_NEXT_LOGIN = Fault(
    "computer.group_at_next_login", Message("Log out and in, or restart."), Severity.WARNING
)
NOT_IN_GROUP = Fault(
    "computer.not_in_group",
    Message("Add the user to the groups gpio and spi, then log out and in."),
    Severity.WARNING,
)
SPI_OFF = Fault(
    "computer.spi_off",
    Message("Run: sudo raspi-config nonint do_spi 0. Then restart the computer."),
)
SPI_NO_ACCESS = Fault(
    "computer.spi_no_access", Message("Add the user to the group spi, then log out and in.")
)
PIN_LIBRARY_MISSING = Fault(
    "computer.pin_library_missing", Message("Run: scripts/setup.sh --robot")
)
PIGPIO_SILENT = Fault("computer.pigpio_silent", Message("Run: sudo systemctl enable --now pigpiod"))
PINS_NO_ACCESS = Fault(
    "computer.pins_no_access", Message("Add the user to the group gpio, then log out and in.")
)
REALTIME_LIMITED = Fault(
    "computer.realtime_limited",
    Message("Allow rtprio and memlock in /etc/security/limits.d, then log out and in."),
    Severity.WARNING,
)
