"""Looks at everything that is to be known about this computer."""

from __future__ import annotations

import errno
import math
import os
import threading
import time
from pathlib import Path
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple, TypeVar, Union
from urllib.parse import urlsplit

from gpr20_common.errors import os_reason
from gpr20_common.low.data_folder import state_folder
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low import network, outside, pi, programs, system
from gpr20_doctor.mid import machine_facts as facts
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse, MachineFacts
from gpr20_doctor.mid.machine_request import MachineRequest
from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.folder.data_folder import (
    DataFolder,
    DataFolderUse,
    KnownFolder,
    existing_folder,
    file_system_of,
)
from gpr20_survey.plan.survey_cost import needed_bytes
from gpr20_survey.trace.ms2026c import MAX_FREQUENCY_POINTS

# Of the VXI-11 instruments: where they say which port to use.
PORTMAPPER = 111
PORT_LIMIT_S = 2.0
# The parts of a robot, as the launch files call them.
ROBOT, SERVER, SURVEY = "robot", "server", "survey"
DISK_LIMIT_S = 4.0

Fact = TypeVar("Fact")


def probe_machine(request: MachineRequest) -> MachineFacts:
    """Return what is known about this computer; what fails is `Unknown`."""
    needed = request.hardware is HardwareUse.NEEDED
    pins = needed and request.pins
    is_pi = pi.is_raspberry_pi(request.root)
    exposed = _known(lambda: _exposed(request))
    nodes = system.ros_processes(request.root).nodes_of(_master(request))
    watchdogs = {one.launch: "" for one in nodes if one.launch}
    watchdogs.update({one.launch: one.watches for one in nodes if one.watches})
    return MachineFacts(
        hardware=request.hardware,
        addresses=_known(lambda: _in_time(lambda: _addresses(request.environment, nodes))),
        software=own_software(),
        temperature_c=_known(lambda: _temperature_c(request.root, is_pi)),
        groups=_known(lambda: pi.groups(request.root)) if needed else None,
        spi=_known(lambda: pi.spi_device(request.root, *request.spi)) if needed else None,
        gpio=_known(lambda: pi.pins(request.root, request.pin_library)) if pins else None,
        realtime=_known(lambda: pi.realtime(PULSE_PRIORITY)) if pins else None,
        power=_known(lambda: pi.power(request.root)) if is_pi else None,
        disk=None if request.data is None else _disk(request.data, request),
        clock=_known(programs.tracking) if request.thorough else None,
        vna=_vna(request.vna),
        pins=request.pins,
        place=request.place,
        two_computers=request.two_computers,
        memory=_known(lambda: system.memory(request.root)),
        volumes=_known(lambda: _in_time(lambda: _volumes(request))),
        outside=_outside(request, exposed),
        closed=exposed == [],
        configuration=_known(lambda: _configuration(request)) if request.files else None,
        files=request.files,
        left_over=tuple(one.number for one in nodes if one.left_over and one.master),
        watchdogs=tuple(watchdogs.values()),
        behind_s=max(0.0, Path(__file__).stat().st_mtime - time.time()),
    )


def _master(request: MachineRequest) -> str:
    return request.environment.get("ROS_MASTER_URI") or f"http://localhost:{system.DEFAULT_PORT}"


def _known(probe: Callable[[], Fact]) -> Union[Fact, Unknown]:
    try:
        return probe()
    except OSError as error:
        return Unknown(os_reason(error))
    except ValueError as error:
        return Unknown(verbatim(str(error)))


def _addresses(
    environment: Mapping[str, str], nodes: Sequence[system.RosNode]
) -> facts.AddressFacts:
    robot, server = (environment.get(name, "") for name in network.ADDRESSES)
    listens_on = environment.get("ROS_HOSTNAME") or environment.get("ROS_IP", "")
    known = sorted({listens_on, *(one.address for one in nodes)} - {""})
    foreign = tuple(
        one for one in known if not any(map(network.is_own_address, network.addresses_of(one)))
    )
    own = network.own_addresses(environment)
    return facts.AddressFacts(robot, server, own, listens_on, foreign)


def _configuration(request: MachineRequest) -> Tuple[Message, ...]:
    part = SURVEY
    if request.two_computers:
        part = ROBOT if request.data is None else SERVER
    return programs.problems(
        request.place.config, request.data_given, request.files, part, request.environment
    )


def _exposed(request: MachineRequest) -> List[Tuple[str, int]]:
    """Return where ROS listens on this computer for more than the computer itself."""
    master = urlsplit(_master(request)).port or system.DEFAULT_PORT
    return [
        (address, port)
        for address, port in system.listening(request.root)
        if port in {master, *request.ports} and not address.startswith("127.")
    ]


def _outside(
    request: MachineRequest, exposed: Union[List[Tuple[str, int]], Unknown]
) -> Union[facts.OutsideFacts, Unknown, None]:
    """Try what a foreign computer reaches; None where nothing of ROS is open to others."""
    if isinstance(exposed, Unknown):
        return exposed
    known = network.own_addresses(request.environment)
    own = [one for one in known if not one.startswith("127.")]
    if not exposed and not own:
        return None
    if not request.thorough or request.surveying:
        return Unknown(Message("it is not tried now"))
    off = request.environment.get("GPR20_FIREWALL") == "off"

    def attempt() -> facts.OutsideFacts:
        # Also of a robot that is off: a port that the doctor opens.
        reached = outside.reached_from_outside(own, exposed)
        ports = tuple(sorted({port for _address, port in reached}))
        return facts.OutsideFacts(len(own) + len(exposed), ports, off)

    return _known(lambda: _in_time(attempt))


def _volumes(request: MachineRequest) -> Tuple[facts.VolumeFacts, ...]:
    """Look at each mount that the robot writes to, once."""
    state = state_folder(request.environment)
    wanted = [request.root, request.root / "var/log", request.place.log, state, request.data]
    found: Dict[str, facts.VolumeFacts] = {}
    for folder in filter(None, wanted):
        existing = existing_folder(folder)
        one, numbers = file_system_of(existing), os.statvfs(str(existing))
        found.setdefault(
            one.mount_point,
            facts.VolumeFacts(
                one.mount_point,
                folder,
                one.read_only,
                numbers.f_bavail * numbers.f_frsize,
                numbers.f_favail if numbers.f_files else None,
            ),
        )
    return tuple(found.values())


def _temperature_c(root: Path, is_pi: bool) -> Optional[float]:
    hottest_c = pi.hottest_c(root)
    if hottest_c is None and is_pi:
        raise ValueError("no thermal zone")
    return hottest_c


def _disk(folder: Path, request: MachineRequest) -> Union[facts.DiskFacts, Unknown]:
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
    trace_s = _known(lambda: _trace_s(existing)) if measured else None
    return facts.DiskFacts(folder, free, known, trace_s)


def _identify(use: DataFolderUse, thorough: bool) -> Union[KnownFolder, Message]:
    folder = DataFolder(use)
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
        return _in_time(lambda: system.slowest_trace_s(folder, trace_bytes))
    except TimeoutError:
        return math.inf


def _vna(address: Union[str, Unknown, None]) -> Union[facts.PortFacts, Unknown, None]:
    if not isinstance(address, str):
        return address
    try:
        network.connect(address, PORTMAPPER, PORT_LIMIT_S)
    except OSError as error:
        return facts.PortFacts(address, PORTMAPPER, os_reason(error))
    return facts.PortFacts(address, PORTMAPPER)
