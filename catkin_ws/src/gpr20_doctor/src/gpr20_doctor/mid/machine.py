"""The computer that is looked at: where things are on it, and which parts of a robot it has."""

from __future__ import annotations

import contextlib
import os
import socket
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Mapping, Optional, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.yaml_file import DEFAULT_FOLDER, configured, data_folder, robot_folder
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import is_here
from gpr20_doctor.low.processes import DEFAULT_MASTER, Processes
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.node_health import axis_node
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.robot_description import STORAGE, NodeDescription

ROOT = Path("/")
# Of the two computers of a robot.
ADDRESSES = ("GPR20_ROBOT", "GPR20_SERVER")
MODEL = "proc/device-tree/model"
SETTINGS = "etc/gpr20/robot.conf"
UNITS = ("lib/systemd/system", "usr/lib/systemd/system")
# Name of the package too. Which part of a robot it runs, GPR20_ROLE says.
SERVICE = "gpr20"
SERVICE_LOGS = "var/log/gpr20"


@dataclass(frozen=True)
class Machine:
    """What a check of this computer is given.

    Attributes:
        environment: The variables of this process; `gpr20-run` gives it those of the services.
        root: Root of the file system.
        config: Folder of the robot's configuration.
        log: Folder of the logs.
        settings: File with the settings of the services; None: no package is installed.
        service: Name of the robot's service here; empty: none is installed.
        host: Name of this computer.
        nodes: What the nodes say they are; empty if they do not run.
        thorough: Whether to check the configuration too, which a launch has done already.
    """

    environment: Mapping[str, str] = field(default_factory=dict)
    root: Path = ROOT
    config: Path = Path(DEFAULT_FOLDER)
    log: Path = Path("~/.ros/log")
    settings: Optional[Path] = None
    service: str = ""
    host: str = ""
    nodes: Mapping[str, NodeDescription] = field(default_factory=dict)
    thorough: bool = True

    @classmethod
    def here(
        cls,
        environment: Mapping[str, str],
        root: Path = ROOT,
        config: Optional[Path] = None,
        nodes: Optional[Mapping[str, NodeDescription]] = None,
        thorough: bool = True,
    ) -> Machine:
        """Return this computer, with what else is known.

        Raises:
            RuntimeError: A folder is that of a user whom nobody knows.
        """
        settings = Path(environment.get("GPR20_ENVIRONMENT") or root / SETTINGS)
        # A folder that may not be searched has no such file for this user.
        has_unit = any(os.path.exists(str(root / one / f"{SERVICE}.service")) for one in UNITS)
        logs = environment.get("ROS_LOG_DIR") or (str(root / SERVICE_LOGS) if has_unit else "")
        return cls(
            environment,
            root,
            config=(config or robot_folder(environment)).expanduser().absolute(),
            log=Path(logs or Path(environment.get("ROS_HOME") or "~/.ros") / "log").expanduser(),
            settings=settings if os.path.exists(str(settings)) else None,
            service=SERVICE if has_unit else "",
            host=socket.gethostname(),
            nodes=nodes or {},
            thorough=thorough,
        )

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
        if self.environment.get("GPR20_ROLE") == "":
            return Message(
                "{remedy} Nothing starts without a role: write GPR20_ROLE into {settings}, then "
                "run: sudo systemctl restart gpr20-firewall {service}",
                settings=self.settings or self.root / SETTINGS,
                **known,
            )
        if self.two_computers:
            return Message(
                "{remedy} Run on both computers: sudo systemctl restart {service}", **known
            )
        return Message(
            "{remedy} Run: sudo systemctl restart {service}. If it is found again, run: journalctl "
            "-u {service} -n 50",
            **known,
        )

    @property
    def simulated(self) -> bool:
        """Whether a simulated robot runs."""
        axis = self.nodes.get(axis_node(AxisId.X))
        return axis is not None and axis.hardware.simulated

    @property
    def two_computers(self) -> bool:
        """Whether the robot has parts on another computer."""
        hosts = {one.software.host for one in self.nodes.values()} - {"", self.host}
        return bool(hosts or any(map(self.environment.get, ADDRESSES)))

    @property
    def drives_hardware(self) -> bool:
        """Whether it is the Raspberry Pi that drives the pins and the bus of a real robot."""
        other = self.is_only("GPR20_SERVER") or self.is_elsewhere(axis_node(AxisId.X))
        return self.is_pi and not (self.simulated or other)

    @property
    def is_pi(self) -> bool:
        """Whether it is a Raspberry Pi."""
        model = self.root / MODEL
        return model.exists() and b"Raspberry Pi" in model.read_bytes()

    @property
    def data(self) -> Optional[Path]:
        """Folder of the surveys; None: not on this computer."""
        if self.is_only("GPR20_ROBOT") or self.is_elsewhere(STORAGE):
            return None
        folder = self.value(STORAGE, "storage.yaml", "data")
        return data_folder(str(folder or ""), self.environment)

    @property
    def own_addresses(self) -> Tuple[str, ...]:
        """Those addresses of the two computers that this one has."""
        given = (self.environment.get(name, "") for name in ADDRESSES)
        return tuple(one for one in given if one and is_here(one))

    @property
    def master(self) -> str:
        """Address of the ROS master."""
        return self.environment.get("ROS_MASTER_URI") or DEFAULT_MASTER

    @cached_property
    def processes(self) -> Processes:
        """What runs here."""
        return Processes(self.root)

    def is_only(self, name: str) -> bool:
        """Return whether this computer is only one of two, the one with an address."""
        return self.own_addresses == (self.environment.get(name),)

    def is_elsewhere(self, node: str) -> bool:
        """Return whether a node runs on another computer."""
        known = self.nodes.get(node)
        return known is not None and known.software.host != self.host

    def value(self, node: str, file: str, key: str) -> Any:
        """Return a value as a node has it, or else as it is configured; None: neither."""
        known = self.nodes.get(node)
        own = None if known is None else known.configuration.get(key)
        return self.configured(file, key) if own is None else own

    def configured(self, file: str, key: str) -> Any:
        """Return a value of a file of the configuration; None: not there, or not readable."""
        with contextlib.suppress(OSError, Gpr20Error):  # the check of the configuration says why
            return configured(self.config / file).get(key)
        return None


@dataclass(frozen=True)
class MachineReport:
    """What the checks of a computer have found, and what the checks of the robot need of it."""

    found: Tuple[Finding, ...] = ()
    software: NodeSoftware = field(default_factory=NodeSoftware)
    machine: Machine = field(default_factory=Machine)
