"""What a remedy says of this computer: its files, and how its services are started again."""

from __future__ import annotations

from dataclasses import replace

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.place import ROBOT, SERVER, Place
from gpr20_survey.faults import OTHER_DATA_FOLDER

LAUNCHES = {ROBOT: "robot.launch", SERVER: "server.launch"}
ALL_IN_ONE = "survey.launch"
ACCEPT_DATA = Message(
    "Plug in and mount the disk of the surveys, then try again. Only if the folder is to be "
    "used from now on, run: sudo -u gpr20 gpr20-run config accept_data"
)


def advised(finding: Finding, place: Place) -> Finding:
    """Return the finding with the files and commands of this computer in its remedy."""
    remedy = finding.remedy
    if remedy is None:
        return finding
    known = {"height_file": printable(place.config / "height.yaml")}
    if place.settings:
        known["where"] = printable(place.settings)
        # Whoever reports it: a check of this computer, or a part of the robot.
        if finding.text.fault_code == OTHER_DATA_FOLDER.code:
            remedy = ACCEPT_DATA
    remedy = remedy.with_values(known)
    if finding.restart is not None:
        restart = _restart(finding.restart, place)
        remedy = Message("{remedy} {restart}", remedy=remedy, restart=restart)
    return replace(finding, remedy=remedy)


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
