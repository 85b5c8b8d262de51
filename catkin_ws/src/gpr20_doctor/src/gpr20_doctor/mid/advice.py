"""What to do about each fault on this computer: two tables, by the codes of the faults.

The fields are filled from the sentence of the fault and from what is known of this computer. A
fault in neither table has its own remedy, which is the same on every computer.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Dict, Optional

from gpr20_common.faults import (
    DISK_FULL,
    DISK_REFUSES,
    INTERNAL,
    NOT_RUNNING,
    NOT_SET_UP,
    OTHER_LAUNCH,
)
from gpr20_common.message import Message, Value
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.place import ROBOT, SERVER, Place
from gpr20_survey.faults import NO_GROUND, OTHER_DATA_FOLDER

LAUNCHES = {ROBOT: "robot.launch", SERVER: "server.launch"}
ALL_IN_ONE = "survey.launch"
_RESTART = Message("{restart}", restart="")
_THEN_RESTART = Message("{remedy} {restart}", remedy="", restart="")
_MOTORS_THEN_RESTART = Message("Switch off the motors' power. {restart}", restart="")
_LISTEN_AS_SERVICES = Message("Run it as the services do: gpr20-run doctor")

ADVICE: Dict[str, Message] = {
    NOT_RUNNING.code: _RESTART,
    NOT_RUNNING.code: _RESTART,
    faults.MASTER_LOST.code: _MOTORS_THEN_RESTART,
    faults.MASTER_LOST.code: _MOTORS_THEN_RESTART,
    NOT_RUNNING.code: Message(
        "Check that the other computer is switched on, the cable between them, and the address "
        "({where}).",
        where="GPR20_SERVER, ROS_MASTER_URI",
    ),
    NOT_RUNNING.code: Message(
        "Run: export ROS_MASTER_URI={first}. Then run the doctor again.", first=""
    ),
    NOT_RUNNING.code: Message(
        "Run: gpr20 doctor --ns {robot}. For every program in this terminal: export "
        "ROS_NAMESPACE={robot}",
        robot="",
    ),
    NOT_RUNNING.code: Message(
        "Wait one minute: what ends is started again by itself. If it stays: {restart}", restart=""
    ),
    INTERNAL.as_warning().code: Message(
        "Run: kill {numbers}. A survey that runs is stopped and can be resumed. Then start the "
        "robot again. {restart}",
        numbers="",
        restart="",
    ),
    OTHER_LAUNCH.as_warning().code: _THEN_RESTART,
    faults.ADDRESS.code: _THEN_RESTART,
    NO_GROUND.as_warning().code: Message(
        "Look below the sensor, and check the offset in {height_file}.", height_file=""
    ),
    NOT_SET_UP.as_warning().code: Message(
        "Run: sudo groupadd --system {group}. Then restart the computer.", group=""
    ),
    NOT_SET_UP.as_warning().code: Message(
        "Run: sudo usermod -aG {group} {user}. Then log out and in.", group="", user=""
    ),
    DISK_REFUSES.code: Message(
        "Run: sudo mount -o remount,rw {point}. If that fails or it happens again, replace the "
        "card or disk.",
        point="",
    ),
    DISK_FULL.code: Message(
        "Delete what is not needed on {point}; to see what is large, run: sudo du -xh {point} | "
        "sort -h | tail",
        point="",
    ),
}
# Where the packages are installed.
WITH_PACKAGES: Dict[str, Message] = {
    OTHER_DATA_FOLDER.code: Message(
        "Plug in and mount the disk of the surveys, then try again. Only if the folder is to be "
        "used from now on, run: sudo -u gpr20 gpr20-run config accept_data"
    ),
    faults.ADDRESS.code: Message(
        "Check the link, and GPR20_ROBOT and GPR20_SERVER in {where}. Then run: sudo systemctl "
        "restart gpr20-firewall",
        where="",
    ),
    faults.ADDRESS.code: _LISTEN_AS_SERVICES,
    faults.ADDRESS.as_warning().code: _LISTEN_AS_SERVICES,
    faults.FIREWALL.code: Message("Run: sudo {program} load", program=""),
    faults.FIREWALL.code: Message(
        "Write GPR20_FIREWALL=on into {where}. Run: sudo {program} load", where="", program=""
    ),
    NOT_SET_UP.as_warning().code: Message(
        "Run: sudo apt install --reinstall gpr20-robot. Then restart the computer."
    ),
}


def advised(finding: Finding, place: Place) -> Finding:
    """Return the finding with the advice for this computer, if its fault has one."""
    code = finding.text.fault_code
    advice: Optional[Message] = WITH_PACKAGES.get(code) if place.settings else None
    advice = advice or ADVICE.get(code)
    if advice is None:
        return finding
    known: Dict[str, Value] = {}
    for text in finding.text.nested():
        known = {**text.values, **known}
    known["restart"] = _restart(str(known.get("service", "")), place)
    known["remedy"] = finding.text.remedy or ""
    known["program"] = printable(place.firewall)
    known["height_file"] = printable(place.config / "height.yaml")
    if place.settings:
        known["where"] = printable(place.settings)
    return replace(finding, remedy=advice.with_values(known))


def _restart(named: str, place: Place) -> Message:
    """Return how to restart the robot, or the one of its services that is named."""
    service = named if place.two_computers else place.service
    if not place.service:
        return Message(
            "End what is left of the robot's launch with Ctrl-C, then start it: {command}",
            command=f"roslaunch gpr20 {LAUNCHES.get(service, ALL_IN_ONE)}",
        )
    if service not in ("", place.service):
        return Message(
            "On the other computer run: sudo systemctl restart {service}. If it is found again, "
            "run there: journalctl -u {service} -n 50",
            service=service,
        )
    return Message(
        "Run: sudo systemctl restart {service}. If it is found again, run: journalctl -u {service} "
        "-n 50",
        service=place.service,
    )
