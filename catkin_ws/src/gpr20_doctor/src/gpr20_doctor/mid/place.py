"""The folders and services that this computer really uses, for checks and advice."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Mapping, Optional

from gpr20_common.low.data_folder import robot_folder
from gpr20_common.message import Message

SETTINGS = "etc/gpr20/environment"
FIREWALL = "/usr/lib/gpr20/firewall"
UNITS = ("lib/systemd/system", "usr/lib/systemd/system")
# With two computers, the one has axes and height sensor, the other the ROS master and the rest.
ROBOT, SERVER = "gpr20-robot", "gpr20-server"
SERVICE_LOGS = "var/log/gpr20"


@dataclass(frozen=True)
class Place:
    """Where things are on this computer.

    Attributes:
        config: Folder of the robot's configuration.
        log: Folder of the logs.
        settings: File with the settings of the services; None: no packages are installed.
        service: Name of the robot's service here; empty: none is installed.
        two_computers: Whether the robot has another computer, by its addresses.
    """

    config: Path = Path("~/.gpr20/robot")
    log: Path = Path("~/.ros/log")
    settings: Optional[Path] = None
    service: str = ""
    two_computers: bool = False

    def restart(self, first: Message) -> Message:
        """Return what to do first, and then how to restart the robot."""
        known = {"remedy": first, "service": self.service}
        if not self.service:
            launch = "robot.launch, server.launch" if self.two_computers else "survey.launch"
            return Message(
                "{remedy} End what is left of the robot's launch with Ctrl-C, then start it: "
                "roslaunch gpr20 {launch}",
                launch=launch,
                **known,
            )
        if self.two_computers:
            return Message(
                "{remedy} Run: sudo systemctl restart {service}, and on the other computer: sudo "
                "systemctl restart {other}",
                other=SERVER if self.service == ROBOT else ROBOT,
                **known,
            )
        return Message(
            "{remedy} Run: sudo systemctl restart {service}. If it is found again, run: journalctl "
            "-u {service} -n 50",
            **known,
        )


NO_PLACE = Place()


def place_of(environment: Mapping[str, str], root: Path, config: Optional[Path] = None) -> Place:
    """Return where things are on this computer.

    Args:
        environment: The variables of this process; `gpr20-run` gives it those of the services.
        root: Root of the file system.
        config: Folder of the configuration that was asked for; None: none was.

    Raises:
        RuntimeError: A folder is that of a user whom nobody knows.
    """
    settings = Path(environment.get("GPR20_ENVIRONMENT") or root / SETTINGS)
    # A folder that may not be searched has no such file for this user.
    units = [
        name
        for name in (ROBOT, SERVER)
        if any(os.path.exists(str(root / one / f"{name}.service")) for one in UNITS)
    ]
    logs = environment.get("ROS_LOG_DIR") or (str(root / SERVICE_LOGS) if units else "")
    return Place(
        config=(config or robot_folder(environment)).expanduser().absolute(),
        log=Path(logs or Path(environment.get("ROS_HOME") or "~/.ros") / "log").expanduser(),
        settings=settings if os.path.exists(str(settings)) else None,
        service=units[0] if units else "",
        two_computers=bool(environment.get("GPR20_SERVER")),
    )
