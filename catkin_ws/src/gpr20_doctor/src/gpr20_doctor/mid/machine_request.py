"""What is to be looked at on this computer, from what is known about the robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import FrozenSet, List, Mapping, Optional, Tuple, Union

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.data_folder import data_folder
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_doctor.low import config_files, network, pi_sensors
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse
from gpr20_doctor.mid.node_health import axis_node
from gpr20_doctor.mid.place import NO_PLACE, Place, place_of
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import Backend
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
        pin_library: Library of the pins in the configuration; empty: not known.
        pins: Whether an axis has pins; False: other controllers move all axes.
        spi: Bus and device of the height sensor's converter.
        data: Folder of the surveys; None: not on this computer.
        data_disk: Whether that folder must be on a disk of its own.
        vna: Address of the VNA; None: not to be checked.
        thorough: Whether to do what takes longer: speed of the disk, VNA, chrony, firewall.
        root: Root of the file system.
        place: Folders and services of this computer.
        two_computers: Whether the robot has parts on another computer.
        surveying: Whether a survey is running or paused.
        ports: Ports of the ROS nodes, wherever they run.
    """

    hardware: HardwareUse
    environment: Mapping[str, str]
    pin_library: str = ""
    pins: bool = True
    spi: Tuple[int, int] = DEFAULT_SPI
    data: Optional[Path] = None
    data_disk: bool = False
    vna: Union[str, Unknown, None] = None
    thorough: bool = True
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
        ports: FrozenSet[int] = frozenset(),
    ) -> MachineRequest:
        """Return what is to be looked at.

        Args:
            nodes: What the nodes say they are; empty if they do not run.
            surveying: Whether a survey is running or paused.
            robot: gpr20, simulated, or auto: what the nodes or this computer say.
            thorough: Whether to do what takes longer.
            ports: Ports of the ROS nodes, wherever they run.
        """
        axis = nodes.get(axis_node(AxisId.X))
        libraries = self._pin_libraries(nodes)
        if robot == AUTOMATIC and axis is not None:
            robot = SIMULATED if axis.hardware.simulated else REAL
        return MachineRequest(
            hardware=self._hardware(robot, axis),
            environment=self.environment,
            pin_library=libraries[0] if libraries else "",
            pins=bool(libraries),
            spi=self._spi(nodes.get(HEIGHT_SENSOR)),
            data=self._data(nodes.get(STORAGE)),
            data_disk=self._data_disk(nodes.get(STORAGE)),
            vna=None if surveying or robot == SIMULATED else self._vna(nodes.get(ANALYZER)),
            thorough=thorough,
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
        if self._is("GPR20_SERVER") or (axis is not None and axis.software.host != self.host):
            return HardwareUse.ELSEWHERE
        if robot == REAL or self._is("GPR20_ROBOT") or pi_sensors.is_raspberry_pi(self.root):
            return HardwareUse.NEEDED
        return HardwareUse.NO_PI

    def _pin_libraries(self, nodes: Mapping[str, NodeDescription]) -> List[str]:
        """Return the library of each axis that has pins; empty: not known."""
        found = []
        for axis_id in AxisId:
            node = nodes.get(axis_node(axis_id))
            own: object
            if node is None:
                own = config_files.configured(self.place.config, "axes.yaml", axis_id.value)
            else:
                own = node.configuration
            if not (isinstance(own, Mapping) and own.get("controller")):
                found.append(_pin_library(node, own))
        return found

    def _spi(self, sensor: Optional[NodeDescription]) -> Tuple[int, int]:
        numbers = []
        for key, default in zip(("spi_bus", "spi_device"), DEFAULT_SPI):
            number = None if sensor is None else sensor.configuration.get(key)
            if number is None:
                number = config_files.configured(self.place.config, "height.yaml", key)
            numbers.append(number if isinstance(number, int) else default)
        return numbers[0], numbers[1]

    def _data(self, storage: Optional[NodeDescription]) -> Optional[Path]:
        if self._is("GPR20_ROBOT") or (storage is not None and storage.software.host != self.host):
            return None
        folder = storage.configuration.get("data") if storage is not None else None
        folder = folder or config_files.configured(self.place.config, "storage.yaml", "data")
        return data_folder(str(folder or ""), self.environment)

    def _data_disk(self, storage: Optional[NodeDescription]) -> bool:
        if storage is not None:
            return storage.configuration.get("data_disk") is True
        return config_files.configured(self.place.config, "storage.yaml", "data_disk") is True

    def _vna(self, analyzer: Optional[NodeDescription]) -> Union[str, Unknown, None]:
        host = "" if analyzer is None else analyzer.software.host
        if self._is("GPR20_ROBOT") or (analyzer is not None and host != self.host):
            return None
        address = analyzer.configuration.get("address") if analyzer is not None else None
        address = address or config_files.configured(self.place.config, "analyzer.yaml", "address")
        if not address:
            return Unknown(Message("its address is not in analyzer.yaml"))
        try:
            ipv4_address("address", str(address))
        except Gpr20Error:
            return None  # an analyzer that is not reached over VXI-11
        return str(address)

    def _is(self, name: str) -> bool:
        """Return whether this computer is only one of two, the one with an address."""
        own = self.own_addresses
        return len(own) == 1 and own[0] == self.environment.get(name)

    @property
    def own_addresses(self) -> Tuple[str, ...]:
        """Those addresses of the two computers that this one has."""
        given = (self.environment.get(name, "") for name in ("GPR20_ROBOT", "GPR20_SERVER"))
        return tuple(one for one in given if one and network.is_own_address(one))


def _pin_library(axis: Optional[NodeDescription], configuration: object) -> str:
    """Return what drives the pins of an axis; empty: nothing, or it is not known."""
    if not isinstance(configuration, Mapping) or (axis is not None and axis.hardware.simulated):
        return ""
    return str(configuration.get("backend", Backend.RPI_GPIO.value))
