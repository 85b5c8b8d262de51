"""What is to be looked at on this computer, from what is known about the robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, FrozenSet, Mapping, Optional, Tuple, Union

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.data_folder import data_folder
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_doctor.low import network, pi
from gpr20_doctor.low.programs import configured
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse
from gpr20_doctor.mid.node_health import axis_node
from gpr20_doctor.mid.place import NO_PLACE, Place, place_of
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, STORAGE, NodeDescription

ROOT = Path("/")
DEFAULT_SPI = (0, 0)
REAL, SIMULATED, AUTOMATIC = "gpr20", "simulated", "auto"


@dataclass(frozen=True)
class MachineRequest:
    """What is to be looked at.

    Attributes:
        hardware: Whether this computer drives the hardware of a robot.
        environment: The environment variables.
        pins: Whether an axis has pins; False: other controllers move all axes.
        spi: Bus and device of the height sensor's converter.
        data: Folder of the surveys; None: not on this computer.
        data_given: That folder as the launch was given it; empty: as configured.
        data_disk: Whether that folder must be on a disk of its own.
        vna: Address of the VNA; None: not to be checked.
        thorough: Whether to do what takes longer: speed of the disk, VNA, chrony, firewall.
        files: The robot as whose the configuration is checked: gpr20 or simulated; empty: none.
        root: Root of the file system.
        place: Folders and services of this computer.
        two_computers: Whether the robot has parts on another computer.
        surveying: Whether a survey is running or paused.
        ports: Ports of the ROS nodes, wherever they run.
    """

    hardware: HardwareUse
    environment: Mapping[str, str]
    pins: bool = True
    spi: Tuple[int, int] = DEFAULT_SPI
    data: Optional[Path] = None
    data_given: str = ""
    data_disk: bool = False
    vna: Union[str, Unknown, None] = None
    thorough: bool = True
    files: str = ""
    root: Path = ROOT
    place: Place = NO_PLACE
    two_computers: bool = False
    surveying: bool = False
    ports: FrozenSet[int] = frozenset()


class ThisMachine:
    """What decides which parts of a robot are on this computer."""

    def __init__(
        self,
        host: str,
        environment: Mapping[str, str],
        root: Path = ROOT,
        config: Optional[Path] = None,
    ) -> None:
        """Find the folders of this computer.

        Args:
            host: Name of this computer.
            environment: The environment variables.
            root: Root of the file system.
            config: Folder of the robot's configuration; None: the one that is used here.

        Raises:
            RuntimeError: A folder is that of a user whom nobody knows.
        """
        self.host, self.root = host, root
        self.place, self.environment = place_of(environment, root, config)

    def request(
        self,
        nodes: Mapping[str, NodeDescription],
        surveying: bool = False,
        robot: str = AUTOMATIC,
        thorough: bool = True,
        files: str = "",
        ports: FrozenSet[int] = frozenset(),
    ) -> MachineRequest:
        """Return what is to be looked at.

        Args:
            nodes: What the nodes say they are; empty if they do not run.
            surveying: Whether a survey is running or paused.
            robot: gpr20, simulated, or auto: what the nodes or this computer say.
            thorough: Whether to do what takes longer.
            files: The robot as whose the configuration is checked: gpr20, simulated, or auto: the
                one that runs, else the real one, whose it is; empty: only if thorough.
            ports: Ports of the ROS nodes, wherever they run.
        """
        axis, storage = nodes.get(axis_node(AxisId.X)), nodes.get(STORAGE)
        if robot == AUTOMATIC and axis is not None:
            robot = SIMULATED if axis.hardware.simulated else REAL
        if files == AUTOMATIC or (thorough and not files):
            files = SIMULATED if robot == SIMULATED else REAL
        data = self._data(storage)
        vna = thorough and not surveying and robot != SIMULATED
        return MachineRequest(
            hardware=self._hardware(robot, axis),
            environment=self.environment,
            pins=self._any_axis_has_pins(nodes),
            spi=self._spi(nodes.get(HEIGHT_SENSOR)),
            data=data,
            data_given=str(data) if data not in (None, self._data(None)) else "",
            data_disk=self._value(storage, "storage.yaml", "data_disk") is True,
            vna=self._vna(nodes.get(ANALYZER)) if vna else None,
            thorough=thorough,
            files=files,
            root=self.root,
            place=self.place,
            two_computers=self._two_computers(nodes),
            surveying=surveying,
            ports=ports,
        )

    def _two_computers(self, nodes: Mapping[str, NodeDescription]) -> bool:
        hosts = {one.software.host for one in nodes.values()} - {"", self.host}
        return bool(hosts or self.environment.get("GPR20_ROBOT"))

    def _hardware(self, robot: str, axis: Optional[NodeDescription]) -> HardwareUse:
        if robot == SIMULATED:
            return HardwareUse.SIMULATED
        if self._is("GPR20_SERVER") or self._is_elsewhere(axis):
            return HardwareUse.ELSEWHERE
        if robot == REAL or self._is("GPR20_ROBOT") or pi.is_raspberry_pi(self.root):
            return HardwareUse.NEEDED
        return HardwareUse.NO_PI

    def _any_axis_has_pins(self, nodes: Mapping[str, NodeDescription]) -> bool:
        for axis_id in AxisId:
            node = nodes.get(axis_node(axis_id))
            own = configured(self.place.config, "axes.yaml", axis_id.value)
            values = own if node is None else node.configuration
            if not (isinstance(values, Mapping) and values.get("controller")):
                return True
        return False

    def _spi(self, sensor: Optional[NodeDescription]) -> Tuple[int, int]:
        keys = zip(("spi_bus", "spi_device"), DEFAULT_SPI)
        found = [(self._value(sensor, "height.yaml", key), default) for key, default in keys]
        bus, device = (one if isinstance(one, int) else default for one, default in found)
        return bus, device

    def _data(self, storage: Optional[NodeDescription]) -> Optional[Path]:
        if self._is("GPR20_ROBOT") or self._is_elsewhere(storage):
            return None
        folder = self._value(storage, "storage.yaml", "data")
        return data_folder(str(folder or ""), self.environment)

    def _vna(self, analyzer: Optional[NodeDescription]) -> Union[str, Unknown, None]:
        if self._is("GPR20_ROBOT") or self._is_elsewhere(analyzer):
            return None
        address = self._value(analyzer, "analyzer.yaml", "address")
        if not address:
            return Unknown(Message("its address is not in analyzer.yaml"))
        try:
            ipv4_address("address", str(address))
        except Gpr20Error:
            return None  # an analyzer that is not reached over VXI-11
        return str(address)

    def _value(self, node: Optional[NodeDescription], file: str, key: str) -> Any:
        """Return a value as a node has it, or else as it is configured; None: neither."""
        own = None if node is None else node.configuration.get(key)
        return configured(self.place.config, file, key) if own is None else own

    def _is_elsewhere(self, node: Optional[NodeDescription]) -> bool:
        return node is not None and node.software.host != self.host

    def _is(self, name: str) -> bool:
        """Return whether this computer is only one of two, the one with an address."""
        return network.own_addresses(self.environment) == (self.environment.get(name),)
