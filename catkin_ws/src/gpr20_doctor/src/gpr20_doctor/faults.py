"""What the doctor itself can report as a fault.

Some remedies depend on the computer, its folders and services: `mid/advice.py` words them there.
"""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message, Severity

MOTORS_THEN_RESTART = Message(
    "Switch off the motors' power. Then end the ROS master and start the robot again."
)
LOAD_FIREWALL = Message("Load the firewall of docs/install.md, as root.")
JOIN_GROUPS = Message("Add the user to the groups gpio and spi, then log out and in.")
LISTEN_HERE = Message("Unset ROS_IP and ROS_HOSTNAME, and source setup.bash again.")

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
MASTER_ENDED = Fault("doctor.master_ended", MOTORS_THEN_RESTART, may_move=True)
MASTER_HANGS = Fault("doctor.master_hangs", MOTORS_THEN_RESTART, may_move=True)
MASTER_UNREACHABLE = Fault("doctor.master_unreachable", remedies.START_ROBOT)
MASTER_ELSEWHERE = Fault(
    "doctor.master_elsewhere", Message("Set ROS_MASTER_URI to the master that has the robot.")
)
OTHER_NAMESPACE = Fault(
    "doctor.other_namespace", Message("Use the namespace of the robot: gpr20 doctor --ns NAME")
)
NO_ROBOT = Fault("doctor.no_robot", remedies.START_ROBOT)
PARTS_MISSING = Fault("doctor.parts_missing", remedies.START_ROBOT)
LEFT_OVER = Fault("doctor.left_over", remedies.RESTART_ROBOT, Severity.WARNING)
NOT_RESTARTED = Fault(
    "node.not_restarted",
    Message("Start all parts of the robot again, from one installation."),
    Severity.WARNING,
)
WATCHDOG_HANGS = Fault("doctor.watchdog_hangs", remedies.RESTART_ROBOT)
NODE_HANGS = Fault(
    "doctor.node_hangs",
    Message(
        "Keep your hands clear of the axes. Wait one minute: the robot ends a part that hangs and "
        "starts it again. If it still hangs, switch the robot off and on."
    ),
)
FILES_WRONG = Fault("doctor.files_wrong", remedies.CHECK_CONFIGURATION)
FIREWALL_OPEN = Fault("network.firewall_open", LOAD_FIREWALL)
FIREWALL_OFF = Fault("network.firewall_off", LOAD_FIREWALL)
MEMORY_LOW = Fault(
    "computer.memory_low",
    Message("End other programs on this computer; to see them, run: ps aux --sort=-rss | head"),
)
MEMORY_RAN_OUT = Fault(
    "computer.memory_ran_out",
    Message(
        "Note which program was ended: sudo dmesg | grep -i oom. Then restart the computer, and "
        "run nothing else beside the robot."
    ),
    Severity.WARNING,
)
VOLUME_READ_ONLY = Fault("computer.volume_read_only", remedies.CHECK_DISK)
VOLUME_FULL = Fault("computer.volume_full", remedies.MAKE_SPACE)
CLOCK_BEHIND = Fault(
    "clock.behind",
    Message("Set the clock, for example: sudo date -s '2026-07-31 14:00'"),
    Severity.WARNING,
)
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
NETWORK_OPEN = Fault("network.open", LISTEN_HERE, Severity.WARNING)
ADDRESS_MISSING = Fault(
    "network.address_missing",
    Message("Check the link, GPR20_ROBOT and GPR20_SERVER, and source setup.bash again."),
)
ADDRESS_WRONG = Fault("network.address_wrong", LISTEN_HERE)
ADDRESS_GONE = Fault(
    "network.address_gone",
    Message("Check the link, and the address of this computer. Then start the robot again."),
)
GROUP_MISSING = Fault(
    "computer.group_missing",
    Message("Make the group, then restart the computer."),
    Severity.WARNING,
)
GROUP_AT_NEXT_LOGIN = Fault(
    "computer.group_at_next_login", Message("Log out and in, or restart."), Severity.WARNING
)
NOT_IN_GROUP = Fault("computer.not_in_group", JOIN_GROUPS, Severity.WARNING)
SPI_OFF = Fault(
    "computer.spi_off",
    Message("Run: sudo raspi-config nonint do_spi 0. Then restart the computer."),
)
SPI_NO_ACCESS = Fault("computer.spi_no_access", JOIN_GROUPS)
PIN_LIBRARY_MISSING = Fault(
    "computer.pin_library_missing", Message("Run: scripts/setup.sh --robot")
)
PIGPIO_SILENT = Fault("computer.pigpio_silent", Message("Run: sudo systemctl enable --now pigpiod"))
PINS_NO_ACCESS = Fault("computer.pins_no_access", JOIN_GROUPS)
REALTIME_LIMITED = Fault(
    "computer.realtime_limited",
    Message("Allow rtprio and memlock in /etc/security/limits.d, then log out and in."),
    Severity.WARNING,
)
