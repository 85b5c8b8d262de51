"""The folders and services that this computer really uses, for checks and advice."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Dict, Mapping, Optional, Tuple

from gpr20_common.low.data_folder import DEFAULT_FOLDER
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor.mid.finding import Finding
from gpr20_survey.faults import OTHER_DATA_FOLDER

SETTINGS = "etc/gpr20/environment"
FIREWALL = "usr/lib/gpr20/firewall"
UNITS = ("lib/systemd/system", "usr/lib/systemd/system")
# With two computers, the one has axes and height sensor, the other the ROS master and the rest.
ROBOT, SERVER = "gpr20-robot", "gpr20-server"
SERVICE_LOGS = "var/log/gpr20"
_SETTING = re.compile(r'(GPR20_[A-Z_]+)="?([^"]*?)"?\s*')


@dataclass(frozen=True)
class Place:
    """Where things are on this computer.

    Attributes:
        config: Folder of the robot's configuration.
        log: Folder of the logs.
        settings: File with the settings of the services; None: no packages are installed.
        service: Name of the robot's service here; empty: none is installed.
        firewall: The program of the packages that loads the firewall.
        two_computers: Whether the robot has another computer, by its addresses.
    """

    config: Path = Path(DEFAULT_FOLDER)
    log: Path = Path("~/.ros/log")
    settings: Optional[Path] = None
    service: str = ""
    firewall: Path = Path("/") / FIREWALL
    two_computers: bool = False


NO_PLACE = Place()


def place_of(
    environment: Mapping[str, str], root: Path, config: Optional[Path] = None
) -> Tuple[Place, Dict[str, str]]:
    """Return where things are, and the environment completed by the settings of the services.

    Args:
        environment: The variables of this process; what is set counts.
        root: Root of the file system.
        config: Folder of the configuration that was asked for; None: none was.

    Raises:
        RuntimeError: A folder is that of a user whom nobody knows.
    """
    settings = Path(environment.get("GPR20_ENVIRONMENT") or root / SETTINGS)
    known = {**_values(settings), **environment}
    folder = config or known.get("GPR20_CONFIG") or DEFAULT_FOLDER
    files = {
        name: [str(root / one / f"{name}.service") for one in UNITS] for name in (ROBOT, SERVER)
    }
    # A folder that may not be searched has no such file for this user.
    units = [name for name, paths in files.items() if any(map(os.path.exists, paths))]
    logs = environment.get("ROS_LOG_DIR") or (str(root / SERVICE_LOGS) if units else "")
    place = Place(
        config=Path(folder).expanduser().absolute(),
        log=Path(logs or Path(environment.get("ROS_HOME") or "~/.ros") / "log").expanduser(),
        settings=settings if os.path.exists(str(settings)) else None,
        service=units[0] if units else "",
        two_computers=bool(known.get("GPR20_SERVER")),
        firewall=root / FIREWALL,
    )
    return place, known


def _values(settings: Path) -> Dict[str, str]:
    try:
        lines = settings.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return {}
    found = filter(None, map(_SETTING.fullmatch, lines))
    return {one.group(1): one.group(2) for one in found}


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
