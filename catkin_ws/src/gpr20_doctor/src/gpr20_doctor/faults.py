"""What the doctor itself can report as a fault; where a check knows more, it says the advice."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

MASTER_LOST = Fault(
    "robot.master_lost",
    Message(
        "If people are near the robot, switch off the motors' power. Then check the cable between "
        "the computers, end the ROS master and start the robot again."
    ),
    may_move=True,
)
CANNOT_WORK = Fault(
    "doctor.cannot_work",
    Message("Remove the reason that the message names, then run gpr20 doctor again."),
)
VOLTAGE_LOW = Fault(
    "computer.voltage_low",
    Message("Charge the battery, and check the supply and its cable (5.1 V, 3 A)."),
)
ADDRESS = Fault(
    "network.address",
    Message(
        "Check the link, GPR20_ROBOT and GPR20_SERVER. Unset ROS_IP and ROS_HOSTNAME, source "
        "setup.bash again, and start the robot again."
    ),
)
FIREWALL = Fault("network.firewall", Message("Load the firewall of docs/install.md, as root."))
