"""The rest of a robot's configuration: its folder, data, addresses, sensors, site and wiring."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, Mapping, Optional, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import CONFIGURATION, DISK_FULL
from gpr20_common.message import Message
from gpr20_common.mid.checks import ipv4_address
from gpr20_common.terminal_text import printable
from gpr20_launch import faults
from gpr20_launch.mid.hints import with_hint
from gpr20_launch.mid.launch_request import ROBOT, SURVEY, storage_parameters
from gpr20_launch.mid.problem import Problem, problem
from gpr20_launch.mid.robot_files import AXES_FILE, Reading
from gpr20_launch.mid.wiring import TASKS, WITH_ROBOT
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.folder.data_folder import IN_MEMORY, DataFolder, existing_folder, file_system_of
from gpr20_survey.folder.signature import key_warning
from gpr20_survey.plan.sensors import SENSORS
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB, ProcessingParameters

STORAGE_FILE, ANALYZER_FILE, HEIGHT_FILE = "storage.yaml", "analyzer.yaml", "height.yaml"
WIRING_FILE = "wiring.yaml"
# Of a line of a profile that a person must check.
PROFILE_MARK = b"# CHECK:"
# What editors, copies and updates of packages leave.
LEFT_OVER = re.compile(
    r".*(~|\.(bak|old|orig|save|sav|tmp|rej|sw[a-p]|backup|copy|new|dpkg-\w+|ucf-\w+)[\d~]*)"
    r"|\.?#.*|\._.*|.*\.ya?ml[._-].+|.*( \(\d+\)|[ -]copy).*",
    re.IGNORECASE,
)
# Folders of the system, and those that it empties.
OF_SYSTEM = ("/bin", "/boot", "/dev", "/etc", "/lib", "/proc", "/sbin", "/sys", "/usr")
EMPTIED = ("/tmp", "/var/tmp", "/var/cache")
OF_MEDIA = ("/media", "/mnt", "/run/media")
# Smaller, they are a slip of the unit, or none was meant.
LEAST_RESERVE_MB, SHORTEST_SETTLING_S = 50.0, 0.05
LEAST_DELAY_NS = 0.001  # 0.15 mm of depth in air
# Resistors and noise aside, 3.3 V.
HIGHEST_INPUT_V = 3.6
ORDER = Message(
    "{launch} of a launch counts before data: in {file}, and that before {variable}",
    launch="data:=",
    file=STORAGE_FILE,
    variable="GPR20_DATA",
)
ADDRESS_NAMES = ("GPR20_ROBOT", "GPR20_SERVER")


@dataclass(frozen=True)
class Use:
    """How the configuration will be used.

    Attributes:
        folder: Its folder.
        environment: The environment variables, with those of the services.
        data: Folder of the surveys that a launch is given; empty: as configured.
        real: Whether the robot is the real one.
        part: What runs on this computer: robot, server, or survey for both.
    """

    folder: Path
    environment: Mapping[str, str]
    data: str = ""
    real: bool = True
    part: str = SURVEY


def check_place(reading: Reading, use: Use) -> Iterator[Problem]:
    """Find what is wrong with data, addresses, sensors, site and wiring."""
    yield from _left_over(use.folder)
    yield from _data(reading, use)
    yield from _sensors(reading)
    yield from _values(reading, use)
    if use.real:
        yield from _addresses(reading, use)
        yield from _unchecked(reading)


def _left_over(folder: Path) -> Iterator[Problem]:
    for path in sorted(folder.iterdir()) if folder.exists() else ():
        if LEFT_OVER.fullmatch(path.name) and path.suffix not in (".yaml", ".yml"):
            text = Message(
                "{file} is left over, and is not read: compare it with the file that is read, keep "
                "the right values there, and move it to another folder",
                file=printable(path),
            )
            yield Problem(text.with_fault(CONFIGURATION.as_warning()), str(path))


def _data(reading: Reading, use: Use) -> Iterator[Problem]:
    given = use.data.strip()
    if not (given or reading.knows(STORAGE_FILE, "data", "data_disk")):
        return
    configured = str(reading.sections["storage"].get("data", "")).strip()
    where = ("data:=", "data") if given else (str(use.folder / STORAGE_FILE), "data")
    if not (given or configured):
        configured = given = use.environment.get("GPR20_DATA", "").strip()
        where = ("environment", "GPR20_DATA") if given else where
    reason = _no_path(given or configured)
    if reason is None and where[0] != "data:=" and configured[:1] not in "/~":
        reason = Message("it depends on the folder in which the robot is started")
    if reason is not None:
        example = Message("an absolute path, such as {example}", example="/srv/gpr20/surveys")
        reason = with_hint(reason, ORDER)
        yield problem(*where, given or configured, reason, example)
    elif use.part != ROBOT:
        parameters = storage_parameters(reading.sections, given)
        unsuitable = list(_suitable(parameters, where, use))
        yield from unsuitable
        if not any(one.refuses for one in unsuitable):
            yield from _disk(parameters, where, use.folder / STORAGE_FILE)


def _no_path(text: str) -> Optional[Message]:
    if not text.isprintable():
        return Message("it has characters that cannot be shown")
    try:
        Path(text).expanduser()
    except RuntimeError:
        return Message("there is no user of this name")
    return None


def _suitable(
    parameters: ProcessingParameters, where: Tuple[str, str], use: Use
) -> Iterator[Problem]:
    folder = parameters.data_folder()
    allowed = Message("a folder of its own on a disk, such as {example}", example="~/gpr20_data")
    inside = [str(one) for one in (folder, *folder.parents)]
    checkout = next((one for one in inside if (Path(one) / ".git").exists()), None)
    home, mounted = map(str, Path.home().parents), file_system_of(existing_folder(folder))
    reason, doubtful = None, True
    if folder in (Path("/"), Path.home()) or set(inside) & set(OF_SYSTEM):
        reason, doubtful = Message("this folder belongs to the system"), False
    elif folder.exists() and not folder.is_dir():
        reason, doubtful = Message("it is no folder"), False
    elif str(use.folder) in inside:
        reason, doubtful = Message("this folder holds the configuration"), False
    elif use.real and mounted.kind in IN_MEMORY:
        reason = Message("this folder is in memory: surveys are lost when the robot is off")
        doubtful = False
    elif not parameters.data:
        return
    elif set(inside) & set(EMPTIED) - set(home):
        reason = Message("the system empties this folder")
    elif set(inside) & set(OF_MEDIA) and not parameters.data_disk:
        reason = Message("without its medium, surveys would be stored on the disk of the system")
        allowed = Message("such a folder with data_disk: true in {file}", file=STORAGE_FILE)
    elif checkout is not None:
        reason = Message(
            "it is inside of the repository {folder}, which people clean and replace",
            folder=printable(checkout),
        )
    elif not folder.exists():
        reason = Message(
            "it does not exist; unless its disk is mounted before, a launch makes it on the file "
            "system of {mount_point}",
            mount_point=printable(mounted.mount_point),
        )
    if reason is not None:
        yield problem(*where, folder, with_hint(reason, ORDER), allowed, doubtful)


def _disk(
    parameters: ProcessingParameters, where: Tuple[str, str], file: Path
) -> Iterator[Problem]:
    use = parameters.data_folder_use()
    try:
        DataFolder(use).identify()
    except ProcessingError as error:
        yield Problem(error.message, *where, printable(use.path))
        return
    free_mb = free_bytes(existing_folder(use.path)) / BYTES_PER_MB
    if free_mb < parameters.disk_reserve_mb:
        reason = Message("{free_mb:.0f} MB are free there, so no survey can start", free_mb=free_mb)
        allowed = f"<= {free_mb:.0f} MB"
        key, value = "disk_reserve_mb", f"{parameters.disk_reserve_mb:g} MB"
        yield problem(file, key, value, reason, allowed, doubtful=True, fault=DISK_FULL)
    unsigned = key_warning(parameters.signer())
    if unsigned is not None:
        text = Message("{file}: {reason}", file=printable(file), reason=unsigned)
        yield Problem(text, str(file), "signing_key", parameters.signing_key)


def _sensors(reading: Reading) -> Iterator[Problem]:
    seen: Dict[Tuple[str, str], str] = {}
    file, allowed = reading.folder / "sensors.yaml", Message("a field of its own for each")
    for number, one in enumerate(reading.record(SENSORS).sensors):
        first = seen.setdefault((one.topic, one.field), one.name)
        if first != one.name:
            reason = Message(
                "sensor {sensor} has this topic and field too, so both have one value", sensor=first
            )
            key, value = f"{SENSORS}[{number}]/field", f"{one.topic} {one.field}"
            yield problem(file, key, value, reason, allowed, doubtful=True)


def _values(reading: Reading, use: Use) -> Iterator[Problem]:
    """Find values that are allowed, but hardly meant."""
    vna, storage, site = map(reading.record, ("vna_acquisition", "storage", "site"))
    height, survey = map(reading.record, ("height_sensor", "survey"))
    uncalibrated = CalibrationStatus.NONE in vna.accepted_calibrations
    sea = site.latitude_deg == site.longitude_deg == 0.0
    for doubtful, file, key, value, reason, allowed in (
        (
            *(sea, "site.yaml", "latitude_deg", 0),
            Message("0, 0 is in the sea; without a position leave both keys out"),
            "-90 - 90",
        ),
        (
            *(uncalibrated, ANALYZER_FILE, "accepted_calibrations", 0),
            Message("surveys would be measured without a calibration"),
            "1 - 5",
        ),
        (
            not vna.accepted_calibrations,
            *(ANALYZER_FILE, "accepted_calibrations", "[]"),
            Message("no calibration of the VNA would be accepted"),
            "1 - 5",
        ),
        (
            0.0 < abs(vna.antenna_delay_ns) < LEAST_DELAY_NS,
            *(ANALYZER_FILE, "antenna_delay_ns", vna.antenna_delay_ns),
            Message("it seems to be in seconds; what is found would be too deep"),
            f"0, or >= {LEAST_DELAY_NS:g} ns",
        ),
        (
            not storage.recorded_topics,
            *(STORAGE_FILE, "recorded_topics", "[]"),
            Message("neither motion nor states would be recorded beside the traces"),
            Message("leave it out; extra_recorded_topics adds others"),
        ),
        (
            storage.disk_reserve_mb < LEAST_RESERVE_MB,
            *(STORAGE_FILE, "disk_reserve_mb", storage.disk_reserve_mb),
            Message("the disk could be full before the end of a survey"),
            f">= {LEAST_RESERVE_MB:g} MB",
        ),
        (
            survey.settle_s < SHORTEST_SETTLING_S,
            *("survey.yaml", "settle_s", survey.settle_s),
            Message("the antennas would still swing while a trace is measured"),
            f">= {SHORTEST_SETTLING_S:g} s",
        ),
        (
            use.real and height.reference_voltage_v > HIGHEST_INPUT_V,
            *(HEIGHT_FILE, "reference_voltage_v"),
            f"{height.reference_voltage_v:g} V",
            Message(
                "a converter with this supply puts it on the MISO pin, which is made for 3.3 V: "
                "supply it with 3.3 V, or put a level shifter between them"
            ),
            f"0.25 - {HIGHEST_INPUT_V:g} V",
        ),
    ):
        if doubtful:
            path = reading.folder / file
            yield problem(path, key, value, reason, allowed, doubtful=True)


def _addresses(reading: Reading, use: Use) -> Iterator[Problem]:
    vna = reading.record("vna_acquisition")
    names = [name for name in ADDRESS_NAMES if use.environment.get(name)]
    known = [("environment", name, use.environment[name]) for name in names]
    # Without an address the window asks for it.
    given = (ANALYZER_FILE, "address") in reading.given and reading.knows(ANALYZER_FILE, "address")
    if use.part != ROBOT and given and vna.analyzer == MS2026C:
        known.append((str(use.folder / ANALYZER_FILE), "address", vna.address))
    seen: Dict[str, str] = {}
    allowed = Message("the address of one device, such as {example}", example="192.168.1.10")
    for file, key, address in known:
        first, reason = seen.setdefault(address, f"{file} {key}"), _not_of_device(address, key)
        if first != f"{file} {key}":
            reason = Message("{first} has the same address", first=first)
        # The window asks for the address of the VNA, too.
        doubtful = key == "address" and address.startswith("127.")
        if reason is not None:
            yield problem(file, key, address, reason, allowed, doubtful=doubtful)
    if len(names) == 1:
        key, address = known[0][1:]
        other = next(one for one in ADDRESS_NAMES if one != key)
        reason = Message("two computers need both addresses, and {other} is empty", other=other)
        allowed = Message("both addresses, or none")
        yield problem("environment", key, address, reason, allowed, doubtful=True)


def _not_of_device(address: str, key: str) -> Optional[Message]:
    try:
        ipv4_address(key, address)
    except Gpr20Error as error:
        return error.message.with_fault(None)
    first, *_middle, last = (int(part) for part in address.split("."))
    if first == 0 or first >= 224 or last in (0, 255):
        return Message("no device can have this address")
    if first == 127:
        return Message("this is the address of each computer for itself")
    return None


def _unchecked(reading: Reading) -> Iterator[Problem]:
    wiring = reading.folder / WIRING_FILE
    allowed = Message("nothing in the list, once a person has checked it and corrected the files")
    for one in reading.record("wiring").unchecked:
        reason = Message("nobody has checked it: {task}", task=TASKS[one])
        where, doubtful = (wiring, "unchecked", one.value), one in WITH_ROBOT
        yield problem(*where, reason, allowed, doubtful, fault=faults.NOT_CHECKED)
    for name in (AXES_FILE, HEIGHT_FILE):
        file = reading.folder / name
        # A profile without the list of what must be checked in it.
        if not wiring.exists() and file.is_file() and PROFILE_MARK in file.read_bytes():
            reason = Message(
                "this file is one of a profile, and the list of what must be checked is not there"
            )
            allowed = Message("a file without this word, once a person has checked each such line")
            mark = PROFILE_MARK.decode()
            yield problem(file, "", mark, reason, allowed, fault=faults.NOT_CHECKED)
