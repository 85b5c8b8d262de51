"""What to do about each fault on this computer: one table, by the codes of the faults.

A fault that is not in the table has its own remedy, which is the same on every computer.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict, Optional

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.place import ROBOT, SERVER, Place
from gpr20_survey.faults import OTHER_DATA_FOLDER

Advice = Callable[[Message, Place], Optional[Message]]
LAUNCHES = {ROBOT: "robot.launch", SERVER: "server.launch"}
ALL_IN_ONE = "survey.launch"


def advised(finding: Finding, place: Place) -> Finding:
    """Return the finding with the advice for this computer, if its fault has one."""
    advice = ADVICE.get(finding.text.fault_code)
    return finding if advice is None else replace(finding, remedy=advice(finding.text, place))


def _value(text: Message, name: str) -> str:
    found = (one.values[name] for one in text.nested() if name in one.values)
    return str(next(found, ""))


def _restart(text: Message, place: Place) -> Message:
    service = _value(text, "service") if place.two_computers else place.service
    if not place.service:
        command = LAUNCHES.get(service, ALL_IN_ONE)
        return Message(
            "End what is left of the robot's launch with Ctrl-C, then start it: {command}",
            command=f"roslaunch gpr20 {command}",
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


def _wait_then_restart(text: Message, place: Place) -> Message:
    restart = _restart(text, place)
    return Message(
        "Wait one minute: what ends is started again by itself. If it stays: {restart}",
        restart=restart,
    )


def _motors_then_restart(text: Message, place: Place) -> Message:
    restart = _restart(text, place)
    return Message("Switch off the motors' power. {restart}", restart=restart)


def _other_namespace(text: Message, _place: Place) -> Message:
    return Message(
        "Run: gpr20 doctor --ns {robot}. For every program in this terminal: export "
        "ROS_NAMESPACE={robot}",
        robot=_value(text, "first"),
    )


def _other_master(text: Message, _place: Place) -> Message:
    return Message(
        "Run: export ROS_MASTER_URI={master}. Then run the doctor again.",
        master=_value(text, "first"),
    )


def _unreachable(_text: Message, place: Place) -> Message:
    where = printable(place.settings) if place.settings else "GPR20_SERVER, ROS_MASTER_URI"
    return Message(
        "Check that the other computer is switched on, the cable between them, and the address "
        "({where}).",
        where=where,
    )


def _address(_text: Message, place: Place) -> Message:
    if place.settings is None:
        return Message(
            "Check the link, correct GPR20_ROBOT and GPR20_SERVER, and source setup.bash again."
        )
    return Message(
        "Check the link, and GPR20_ROBOT and GPR20_SERVER in {file}. Then run: sudo systemctl "
        "restart gpr20-firewall",
        file=printable(place.settings),
    )


def _listening(_text: Message, place: Place) -> Message:
    if place.settings is None:
        return faults.LISTEN_HERE
    return Message("Run it as the services do: gpr20-run doctor")


def _firewall_open(_text: Message, place: Place) -> Message:
    if place.firewall is None:
        return faults.LOAD_FIREWALL
    return Message("Run: sudo {program} load", program=printable(place.firewall))


def _firewall_off(text: Message, place: Place) -> Message:
    load = _firewall_open(text, place)
    if place.settings is None:
        return load
    file = printable(place.settings)
    return Message("Write GPR20_FIREWALL=on into {file}. {load}", file=file, load=load)


def _height(_text: Message, place: Place) -> Message:
    file = printable(place.config / "height.yaml")
    return Message("Look below the sensor, and check the offset in {file}.", file=file)


def _group_missing(text: Message, place: Place) -> Message:
    if place.settings is not None:
        return Message("Run: sudo apt install --reinstall gpr20-robot. Then restart the computer.")
    return Message(
        "Run: sudo groupadd --system {group}. Then restart the computer.",
        group=_value(text, "group"),
    )


def _not_in_group(text: Message, _place: Place) -> Message:
    return Message(
        "Run: sudo usermod -aG {group} {user}. Then log out and in.",
        group=_value(text, "group"),
        user=_value(text, "user"),
    )


def _read_only(text: Message, _place: Place) -> Message:
    return Message(
        "Run: sudo mount -o remount,rw {point}. If that fails or it happens again, replace the "
        "card or disk.",
        point=_value(text, "point"),
    )


def _full(text: Message, _place: Place) -> Message:
    return Message(
        "Delete what is not needed on {point}; to see what is large, run: sudo du -xh {point} | "
        "sort -h | tail",
        point=_value(text, "point"),
    )


def _other_data(text: Message, place: Place) -> Optional[Message]:
    if place.settings is None:
        return text.remedy
    return Message(
        "Plug in and mount the disk of the surveys, then try again. Only if the folder is to be "
        "used from now on, run: sudo -u gpr20 gpr20-run config accept_data"
    )


ADVICE: Dict[str, Advice] = {
    OTHER_DATA_FOLDER.code: _other_data,
    faults.NO_MASTER.code: _restart,
    faults.MASTER_ENDED.code: _motors_then_restart,
    faults.MASTER_HANGS.code: _motors_then_restart,
    faults.MASTER_UNREACHABLE.code: _unreachable,
    faults.MASTER_ELSEWHERE.code: _other_master,
    faults.OTHER_NAMESPACE.code: _other_namespace,
    faults.NO_ROBOT.code: _restart,
    faults.PARTS_MISSING.code: _wait_then_restart,
    faults.ADDRESS_MISSING.code: _address,
    faults.ADDRESS_WRONG.code: _listening,
    faults.NETWORK_OPEN.code: _listening,
    faults.FIREWALL_OPEN.code: _firewall_open,
    faults.FIREWALL_OFF.code: _firewall_off,
    faults.HEIGHT_UNUSUAL.code: _height,
    faults.GROUP_MISSING.code: _group_missing,
    faults.NOT_IN_GROUP.code: _not_in_group,
    faults.VOLUME_READ_ONLY.code: _read_only,
    faults.VOLUME_FULL.code: _full,
}
