"""Looks at everything that is to be known about this computer."""

from __future__ import annotations

import errno
import math
import os
import threading
import time
from pathlib import Path
from typing import Callable, Dict, List, Mapping, Optional, Tuple, TypeVar, Union
from urllib.parse import urlsplit

from gpr20_common.low.clock import Clock
from gpr20_common.low.data_folder import state_folder
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_software import own_software
from gpr20_common.os_reason import os_reason
from gpr20_doctor.low import (
    chrony,
    device_files,
    disk_speed,
    groups,
    network,
    outside,
    pi_sensors,
    pin_libraries,
    realtime_limits,
    system,
    whole_check,
)
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import (
    PIN_MODULES,
    AddressFacts,
    ClockFacts,
    DeviceFile,
    DiskFacts,
    GpioFacts,
    GroupFacts,
    HardwareUse,
    MachineFacts,
    MemoryFacts,
    OutsideFacts,
    PortFacts,
    PowerFacts,
    RealtimeFacts,
    VolumeFacts,
)
from gpr20_doctor.mid.machine_request import REAL, SIMULATED, MachineRequest
from gpr20_doctor.mid.place import default_configuration
from gpr20_survey.axes.realtime_priority import PULSE_PRIORITY
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.files.file_system import existing_folder, file_system_of
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse, KnownFolder
from gpr20_survey.plan.survey_cost import needed_bytes
from gpr20_survey.trace.ms2026c import MAX_FREQUENCY_POINTS

LOOPBACK = "127.0.0.1"
# Of the VXI-11 instruments: where they say which port to use.
PORTMAPPER = 111
PORT_LIMIT_S = 2.0
# The parts of a robot, as the launch files call them.
ROBOT, SERVER, SURVEY = "robot", "server", "survey"
DISK_LIMIT_S = 4.0
DAEMON_LIMIT_S = 0.1
# Bits of the firmware: low voltage now and before, slowed down now.
LOW_NOW, SLOW_NOW, LOW_BEFORE = 1 << 0, 1 << 2, 1 << 16

Fact = TypeVar("Fact")


def probe_machine(request: MachineRequest) -> MachineFacts:
    """Return what is known about this computer; what fails is `Unknown`."""
    needed = request.hardware is HardwareUse.NEEDED
    pins = needed and request.pins
    spi = device_files.spi_device(request.root, *request.spi)
    pi = pi_sensors.is_raspberry_pi(request.root)
    exposed = _known(lambda: _exposed(request))
    return MachineFacts(
        hardware=request.hardware,
        addresses=_known(lambda: _addresses(request.environment)),
        software=own_software(),
        temperature_c=_known(lambda: _temperature_c(request.root, pi)),
        groups=_known(lambda: _groups(request.root)) if needed else None,
        spi=_known(lambda: _device(spi)) if needed else None,
        gpio=_known(lambda: _gpio(request)) if pins else None,
        realtime=_known(_realtime) if pins else None,
        power=_known(lambda: _power(request.root)) if pi else None,
        disk=None if request.data is None else _disk(request.data, request),
        clock=_known(_clock) if request.thorough else None,
        vna=_vna(request.vna) if request.thorough else None,
        pins=request.pins,
        place=request.place,
        two_computers=request.two_computers,
        memory=_known(lambda: MemoryFacts(*system.memory(request.root))),
        volumes=_known(lambda: _in_time(lambda: _volumes(request))),
        outside=_outside(request, exposed),
        closed=exposed == [],
        configuration=_known(lambda: _configuration(request)) if request.thorough else None,
        behind_s=max(0.0, Path(__file__).stat().st_mtime - time.time()),
    )


def _known(probe: Callable[[], Fact]) -> Union[Fact, Unknown]:
    try:
        return probe()
    except OSError as error:
        return Unknown(os_reason(error))
    except ValueError as error:
        return Unknown(verbatim(str(error)))


def _addresses(environment: Mapping[str, str]) -> AddressFacts:
    robot, server = (environment.get(name, "") for name in ("GPR20_ROBOT", "GPR20_SERVER"))
    return AddressFacts(
        robot=robot,
        server=server,
        own=tuple(one for one in (robot, server) if one and network.is_own_address(one)),
        ros_address=environment.get("ROS_HOSTNAME") or environment.get("ROS_IP", ""),
        master_uri=environment.get("ROS_MASTER_URI", ""),
    )


def _configuration(request: MachineRequest) -> Tuple[Message, ...]:
    # A computer that is no part of a real robot, as far as is known, needs no address of a VNA.
    simulated = request.hardware in (HardwareUse.SIMULATED, HardwareUse.NO_PI)
    part = SURVEY
    if request.two_computers:
        part = ROBOT if request.data is None else SERVER
    folder = request.place.config
    # Without the default folder the defaults are used, and that is no mistake.
    missing = folder == default_configuration() and not os.path.exists(str(folder))
    robot = SIMULATED if simulated else REAL
    return whole_check.problems(None if missing else folder, request.data, robot, part)


def _exposed(request: MachineRequest) -> List[Tuple[str, int]]:
    """Return where ROS listens on this computer for more than the computer itself."""
    master = urlsplit(request.environment.get("ROS_MASTER_URI", "")).port or system.DEFAULT_PORT
    return [
        (address, port)
        for address, port in system.listening(request.root)
        if port in {master, *request.ports} and not address.startswith("127.")
    ]


def _outside(
    request: MachineRequest, exposed: Union[List[Tuple[str, int]], Unknown]
) -> Union[OutsideFacts, Unknown, None]:
    """Try what a foreign computer reaches; None where nothing of ROS is open to others."""
    if isinstance(exposed, Unknown):
        return exposed
    own = [one for one in _addresses(request.environment).own if not one.startswith("127.")]
    if not exposed and not own:
        return None
    if not request.thorough or request.surveying:
        return Unknown(Message("it is not tried now"))
    off = request.environment.get("GPR20_FIREWALL") == "off"

    def attempt() -> OutsideFacts:
        # Also of a robot that is off: a port that the doctor opens.
        reached = outside.reached_from_outside(own, exposed)
        ports = tuple(sorted({port for _address, port in reached}))
        return OutsideFacts(len(own) + len(exposed), ports, off)

    return _known(lambda: _in_time(attempt))


def _volumes(request: MachineRequest) -> Tuple[VolumeFacts, ...]:
    """Look at each mount that the robot writes to, once."""
    state = state_folder(request.environment)
    wanted = [request.root, request.root / "var/log", request.place.log, state, request.data]
    found: Dict[str, VolumeFacts] = {}
    for folder in filter(None, wanted):
        existing = existing_folder(folder)
        one, numbers = file_system_of(existing), os.statvfs(str(existing))
        found.setdefault(
            one.mount_point,
            VolumeFacts(
                one.mount_point,
                folder,
                one.read_only,
                numbers.f_bavail * numbers.f_frsize,
                numbers.f_favail if numbers.f_files else None,
            ),
        )
    return tuple(found.values())


def _temperature_c(root: Path, pi: bool) -> Optional[float]:
    hottest_c = pi_sensors.hottest_c(root)
    if hottest_c is None and pi:
        raise ValueError("no thermal zone")
    return hottest_c


def _groups(root: Path) -> GroupFacts:
    names = groups.group_names(root)
    user = groups.user_name()
    return GroupFacts(
        user=user,
        is_root=os.geteuid() == 0,
        existing=frozenset(names.values()),
        member=frozenset(names[one] for one in {*os.getgroups(), os.getegid()} if one in names),
        listed=groups.groups_listing(root, user),
    )


def _device(path: Path) -> DeviceFile:
    return DeviceFile(path, path.exists(), device_files.can_be_used(path))


def _gpio(request: MachineRequest) -> GpioFacts:
    return GpioFacts(
        devices=tuple(_device(path) for path in device_files.gpio_devices(request.root)),
        libraries=pin_libraries.installed(PIN_MODULES),
        wanted=request.pin_library,
        daemon=_is_open(LOOPBACK, pin_libraries.DAEMON_PORT),
    )


def _is_open(address: str, port: int) -> bool:
    try:
        network.connect(address, port, DAEMON_LIMIT_S)
    except OSError:
        return False
    return True


def _realtime() -> RealtimeFacts:
    return RealtimeFacts(
        realtime_limits.priority_limit(),
        realtime_limits.can_set_priority(PULSE_PRIORITY),
        realtime_limits.memory_limit(),
    )


def _power(root: Path) -> PowerFacts:
    bits = pi_sensors.throttled_bits()
    if bits is not None:
        return PowerFacts(bool(bits & LOW_NOW), bool(bits & LOW_BEFORE), bool(bits & SLOW_NOW))
    low = pi_sensors.low_voltage(root)
    if low is None:
        raise ValueError("neither vcgencmd nor rpi_volt")
    return PowerFacts(low)


def _disk(folder: Path, request: MachineRequest) -> Union[DiskFacts, Unknown]:
    # A launch makes the folder; until then its disk is that of the folder around it.
    existing = _known(lambda: _in_time(lambda: existing_folder(folder)))
    if isinstance(existing, Unknown):
        return existing
    free = _known(lambda: _in_time(lambda: free_bytes(existing)))
    if isinstance(free, Unknown):
        return free
    use = DataFolderUse(folder, state_folder(request.environment), request.data_disk)
    known = _known(lambda: _in_time(lambda: _identify(use, request.thorough)))
    # Nothing is written where no survey is stored.
    measured = request.thorough and not isinstance(known, Message)
    return DiskFacts(folder, free, known, _known(lambda: _trace_s(existing)) if measured else None)


def _identify(use: DataFolderUse, thorough: bool) -> Union[KnownFolder, Message]:
    folder = DataFolder(use, Clock())
    try:
        known = folder.identify()
        if thorough:
            folder.check_file_system()
    except ProcessingError as error:
        # The storage may be allowed what this user is not.
        if isinstance(error.__cause__, PermissionError):
            raise error.__cause__ from None
        return error.message
    return known


def _in_time(probe: Callable[[], Fact]) -> Fact:
    """Return what a probe finds on a disk, which cannot be interrupted if it hangs.

    Raises:
        OSError: The probe failed, or took too long.
    """
    found: List[Union[Fact, OSError]] = []

    def look() -> None:
        try:
            found.append(probe())
        except OSError as error:
            found.append(error)

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    thread.join(DISK_LIMIT_S)
    if not found:
        raise TimeoutError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT))
    if isinstance(found[0], OSError):
        raise found[0]
    return found[0]


def _trace_s(folder: Path) -> float:
    """Return how long the disk takes for one trace [s]; infinite if it hangs."""
    trace_bytes = needed_bytes(1, MAX_FREQUENCY_POINTS, 0.0)
    try:
        return _in_time(lambda: disk_speed.slowest_trace_s(folder, trace_bytes))
    except TimeoutError:
        return math.inf


def _clock() -> ClockFacts:
    tracked = chrony.tracking()
    if tracked is None:
        raise ValueError("no chrony")
    return ClockFacts(*tracked)


def _vna(address: Union[str, Unknown, None]) -> Union[PortFacts, Unknown, None]:
    if not isinstance(address, str):
        return address
    try:
        network.connect(address, PORTMAPPER, PORT_LIMIT_S)
    except OSError as error:
        return PortFacts(address, PORTMAPPER, os_reason(error))
    return PortFacts(address, PORTMAPPER)
