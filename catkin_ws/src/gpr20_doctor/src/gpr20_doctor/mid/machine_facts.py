"""What is known about the computer on which the doctor runs."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Tuple, Union

from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low import pi
from gpr20_doctor.low.programs import Tracking
from gpr20_doctor.low.system import Memory
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.place import NO_PLACE, Place
from gpr20_survey.folder.data_folder import KnownFolder


class HardwareUse(enum.Enum):
    """Whether this computer drives the pins and the bus of a robot."""

    NEEDED = "needed"
    SIMULATED = "simulated"
    ELSEWHERE = "elsewhere"
    NO_PI = "no Raspberry Pi"


@dataclass(frozen=True)
class DiskFacts:
    """The disk of the surveys.

    Attributes:
        folder: The folder of the surveys.
        free_bytes: What may still be written [bytes].
        known: What the folder is, or why no survey can be stored in it.
        trace_s: Time to write one large trace durably [s]; None: not measured.
    """

    folder: Path
    free_bytes: int
    known: Union[KnownFolder, Message, Unknown]
    trace_s: Union[float, Unknown, None] = None


@dataclass(frozen=True)
class AddressFacts:
    """Addresses of the two machines, and where ROS listens.

    Attributes:
        robot: GPR20_ROBOT; empty: not set.
        server: GPR20_SERVER; empty: not set.
        own: Those of the two that this computer has.
        ros_address: ROS_HOSTNAME or ROS_IP; empty: not set.
        foreign: Where ROS and the robot's parts here listen, if it is no address of this computer.
    """

    robot: str
    server: str
    own: Tuple[str, ...]
    ros_address: str
    foreign: Tuple[str, ...] = ()


@dataclass(frozen=True)
class VolumeFacts:
    """A file system that the robot writes to.

    Attributes:
        mount_point: Where it begins.
        folder: The first of the folders on it that are looked at.
        read_only: Whether nothing can be written.
        free_bytes: What may still be written [bytes].
        free_files: How many files may still be made; None: as many as there is space.
    """

    mount_point: str
    folder: Path
    read_only: bool
    free_bytes: int
    free_files: Optional[int] = None


@dataclass(frozen=True)
class OutsideFacts:
    """What a computer with a foreign address reached when that was tried.

    Attributes:
        tried: Number of the ports.
        reached: Those that took a connection.
        switched_off: Whether the settings of the services say that there is no firewall.
    """

    tried: int
    reached: Tuple[int, ...] = ()
    switched_off: bool = False


@dataclass(frozen=True)
class PortFacts:
    """Whether a TCP port can be reached.

    Attributes:
        address: Address of the other device.
        port: Its port.
        failure: Why it cannot be reached; None if it can.
    """

    address: str
    port: int
    failure: Optional[Message] = None


@dataclass(frozen=True)
class MachineFacts:
    """What is known about this computer; None: not asked for.

    Attributes:
        hardware: Whether it drives the hardware of a robot.
        addresses: Of the two machines.
        software: What is installed here.
        temperature_c: Of the processor [°C].
        groups: Of the user.
        spi: Device of the SPI bus.
        gpio: Access to the pins.
        realtime: Limits of pulses.
        power: Supply of a Raspberry Pi.
        disk: Disk of the surveys.
        clock: What chrony says.
        vna: Whether the VNA can be reached.
        pins: Whether an axis has pins; False: other controllers move all axes.
        place: Folders and services of this computer.
        two_computers: Whether the robot has parts on another computer.
        memory: Memory of this computer.
        volumes: File systems that the robot writes to.
        outside: What a foreign computer reaches.
        closed: Whether nothing of ROS can be reached but from this computer.
        configuration: What the check of the whole robot found, with its faults.
        files: The robot as whose the files were checked: gpr20 or simulated.
        left_over: Process ids of the robot's nodes here whose roslaunch has ended.
        watchdogs: State (proc(5)) of the watchdog of each launch here; empty: it does not run.
        behind_s: How far this clock is before the making of the installed software [s].
    """

    hardware: HardwareUse
    addresses: Union[AddressFacts, Unknown]
    software: NodeSoftware
    temperature_c: Union[float, Unknown, None] = None
    groups: Union[pi.Groups, Unknown, None] = None
    spi: Union[pi.DeviceFile, Unknown, None] = None
    gpio: Union[pi.Pins, Unknown, None] = None
    realtime: Union[pi.Realtime, Unknown, None] = None
    power: Union[pi.Power, Unknown, None] = None
    disk: Union[DiskFacts, Unknown, None] = None
    clock: Union[Tracking, Unknown, None] = None
    vna: Union[PortFacts, Unknown, None] = None
    pins: bool = True
    place: Place = NO_PLACE
    two_computers: bool = False
    memory: Union[Memory, Unknown, None] = None
    volumes: Union[Tuple[VolumeFacts, ...], Unknown, None] = None
    outside: Union[OutsideFacts, Unknown, None] = None
    closed: bool = False
    configuration: Union[Tuple[Message, ...], Unknown, None] = None
    files: str = ""
    left_over: Tuple[int, ...] = ()
    watchdogs: Tuple[str, ...] = ()
    behind_s: float = 0.0
