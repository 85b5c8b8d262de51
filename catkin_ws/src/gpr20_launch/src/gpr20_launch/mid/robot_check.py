"""The one check of a whole robot: what is wrong or doubtful in its configuration."""

from __future__ import annotations

import os
import sys
from contextlib import redirect_stdout
from dataclasses import replace
from ipaddress import IPv4Address, ip_address
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, Tuple, get_args

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import CONFIGURATION, DISK_FULL
from gpr20_common.low.clock import Clock
from gpr20_common.low.yaml_file import DEFAULT_FOLDER
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.checks import is_extension
from gpr20_common.mid.codec import plain
from gpr20_common.terminal_text import printable
from gpr20_launch import faults
from gpr20_launch.mid.axis_checks import HEIGHT_FILE, check_axes, check_pins
from gpr20_launch.mid.robot_files import (
    AXES_FILE,
    ROBOT,
    SERVER,
    Problem,
    Reading,
    Use,
    WithRobot,
    problem,
)
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.durable_files import free_bytes
from gpr20_survey.folder.data_folder import IN_MEMORY, DataFolder, existing_folder, file_system_of
from gpr20_survey.folder.signature import key_warning
from gpr20_survey.plan.robot_description import SENSORS
from gpr20_survey.trace.sweep import CalibrationStatus
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB, ProcessingParameters

ANALYZER_FILE, WIRING_FILE, SENSORS_FILE = "analyzer.yaml", "wiring.yaml", "sensors.yaml"
STORAGE_FILE = "storage.yaml"
ADDRESS_NAMES = ("GPR20_ROBOT", "GPR20_SERVER")
# Folders of the system, and those that it empties.
OF_SYSTEM = ("/bin", "/boot", "/dev", "/etc", "/lib", "/proc", "/sbin", "/sys", "/usr")
EMPTIED = ("/tmp", "/var/tmp", "/var/cache")
OF_MEDIA = ("/media", "/mnt", "/run/media")
ORDER = "; data:= of a launch counts before data: in storage.yaml, and that before GPR20_DATA"


def check_robot(
    reading: Reading, use: Use, message_field: Callable[[str, str], object]
) -> Tuple[Problem, ...]:
    """Return what is wrong with the configuration of a robot, and what is doubtful, gravest first.

    Nothing is started, and nothing written. Files that are not there mean the defaults.

    Args:
        reading: The configuration.
        use: What it is for.
        message_field: Finds a field of the messages of a type that is installed here, such as
            data of std_msgs/Float64, and raises InvalidValueError if there is none.
    """
    found = [*reading.problems, *check_pins(reading), *check_axes(reading), *_no_folder(reading)]
    if use.part != ROBOT:
        found += _data(reading, use)
    for file, key, value, reason, allowed in _doubts(reading):
        path = reading.folder / file
        found.append(problem(path, key, plain(value), reason, allowed, doubtful=True))
    if use.real:
        found += [*_addresses(reading, use), *_unchecked(reading)]
    # What a class of others prints when it is imported is no part of this answer.
    with redirect_stdout(sys.stderr):
        found += [*_extensions(reading, use), *_sensors(reading, use, message_field)]
    return tuple(sorted(found, key=lambda one: not one.refuses))


def _data(reading: Reading, use: Use) -> Iterator[Problem]:
    """Find why surveys cannot be stored, or hardly, in the folder that counts."""
    storage, file = reading.record("storage"), str(reading.folder / STORAGE_FILE)
    if "storage" in reading.unsure:
        return
    sources = (
        (use.data.strip(), "data:=", "data"),
        (storage.data.strip(), file, "data"),
        (use.environment.get("GPR20_DATA", "").strip(), "environment", "GPR20_DATA"),
    )
    text, place, key = next((one for one in sources if one[0]), ("", file, "data"))
    # A relative one depends on the folder in which the robot is started.
    absolute = place == "data:=" or text[:1] in "/~"
    if not (absolute and text.isprintable() and "~" not in os.path.expanduser(text)[:1]):
        allowed = "an absolute path, such as /srv/gpr20/surveys"
        yield problem(place, key, text, "no folder is meant by this" + ORDER, allowed)
        return
    storage = replace(storage, data=text)
    mistake = _mistake(storage, reading.folder, use.real)
    reason = mistake or (_doubt(storage) if text else "")
    if reason:
        allowed = "a folder of its own on a disk, such as ~/gpr20_data"
        yield problem(place, key, storage.data_folder(), reason + ORDER, allowed, not mistake)
    if not mistake:
        yield from _disk(storage, (place, key), file)


def _mistake(storage: ProcessingParameters, configuration: Path, real: bool) -> str:
    folder = storage.data_folder()
    inside = {folder, *folder.parents}
    if folder in (Path("/"), Path.home()) or inside & set(map(Path, OF_SYSTEM)):
        return "this folder belongs to the system"
    if str(folder) in EMPTIED:
        return "this folder belongs to every program, and the system empties it"
    if folder.exists() and not folder.is_dir():
        return "it is no folder"
    if configuration in inside:
        return "this folder holds the configuration"
    if real and file_system_of(existing_folder(folder)).kind in IN_MEMORY:
        return "this folder is in memory: surveys are lost when the robot is off"
    return ""


def _doubt(storage: ProcessingParameters) -> str:
    folder = storage.data_folder()
    inside = [folder, *folder.parents]
    if {*map(str, inside)} & {*EMPTIED} - {*map(str, Path.home().parents)}:
        return "the system empties this folder"
    if {*map(str, inside)} & {*OF_MEDIA} and not storage.data_disk:
        return (
            "without its medium, surveys would be stored on the disk of the system, unless "
            f"data_disk: true is in {STORAGE_FILE}"
        )
    if not folder.exists():
        mount_point = file_system_of(existing_folder(folder)).mount_point
        return (
            "it does not exist; unless its disk is mounted before, a launch makes it on the file "
            f"system of {mount_point}"
        )
    return ""


def _disk(storage: ProcessingParameters, where: Tuple[str, str], file: str) -> Iterator[Problem]:
    use = storage.data_folder_use()
    try:
        DataFolder(use).identify()
    except ProcessingError as error:
        yield Problem(error.message, *where, printable(use.path))
        return
    free_mb = free_bytes(existing_folder(use.path)) / BYTES_PER_MB
    if free_mb < storage.disk_reserve_mb:
        reason = f"{free_mb:.0f} MB are free there, so no survey can start"
        key, value = "disk_reserve_mb", f"{storage.disk_reserve_mb:g} MB"
        yield problem(file, key, value, reason, f"<= {free_mb:.0f} MB", True, DISK_FULL)
    unsigned = key_warning(storage.signer())
    if unsigned is not None:
        text = Message("{file}: {reason}", file=printable(file), reason=unsigned)
        yield Problem(text, file, "signing_key", storage.signing_key)


def _doubts(reading: Reading) -> Iterator[Tuple[str, str, Any, str, str]]:
    """Find values that are allowed, but hardly meant: where, why, and what is usual."""
    names = ("vna_acquisition", "survey", "web", "height_sensor")
    vna, survey, web, height = map(reading.record, names)
    accepted = vna.accepted_calibrations
    if CalibrationStatus.NONE in accepted or not accepted:
        reason = "surveys would be measured without a calibration, or never"
        yield ANALYZER_FILE, "accepted_calibrations", accepted, reason, "1 - 5"
    # A thousandth of it is 0.15 mm of depth in air.
    if 0.0 < abs(vna.antenna_delay_ns) < 0.001:
        reason = "it seems to be in seconds; what is found would be too deep"
        yield ANALYZER_FILE, "antenna_delay_ns", vna.antenna_delay_ns, reason, "0, or >= 0.001 ns"
    if survey.settle_s < 0.05:
        reason = "the antennas would still swing while a trace is measured"
        yield "survey.yaml", "settle_s", survey.settle_s, reason, ">= 0.05 s"
    interval_s = survey.reference_interval_s
    if 0.0 < interval_s < 60.0:
        reason = "a survey would spend its time on the way to its first stop and back"
        yield "survey.yaml", "reference_interval_s", interval_s, reason, "0, or >= 60 s"
    if web.port == 11311:
        reason = "this is the port of the ROS master"
        yield "web.yaml", "port", web.port, reason, f"another port, such as {type(web).port}"
    if ip_address(web.address).is_unspecified:
        reason = "the page is open to every network of this computer"
        yield "web.yaml", "address", web.address, reason, "its address in the browsers' network"
    # Resistors and noise aside, 3.3 V.
    if height.reference_voltage_v > 3.6:
        reason = "a converter at 5 V puts that on the MISO pin, which is made for 3.3 V: supply it "
        reason += "with 3.3 V, or put a level shifter between them"
        value = height.reference_voltage_v
        yield HEIGHT_FILE, "reference_voltage_v", value, reason, "0.25 - 3.6 V"


def _no_folder(reading: Reading) -> Iterator[Problem]:
    folder = reading.folder
    if not folder.exists() and folder != Path(DEFAULT_FOLDER).expanduser():
        text = f"the folder {folder} does not exist; correct its name, or create it with "
        text += f"robot_config create {folder}"
        yield Problem(verbatim(text).with_fault(CONFIGURATION), str(folder))


def _addresses(reading: Reading, use: Use) -> Iterator[Problem]:
    named = {name: use.environment.get(name, "") for name in ADDRESS_NAMES}
    known = [("environment", name, address) for name, address in named.items() if address]
    vna = reading.record("vna_acquisition")
    # Without an address the window asks for it.
    given = (ANALYZER_FILE, "address") in reading.given and "vna_acquisition" not in reading.unsure
    if use.part != ROBOT and given and vna.analyzer == MS2026C:
        known.append((str(reading.folder / ANALYZER_FILE), "address", vna.address))
    seen: Dict[str, str] = {}
    for file, key, address in known:
        first, reason = seen.setdefault(address, f"{file} {key}"), _not_of_device(address)
        if first != f"{file} {key}":
            reason = f"{first} has the same address"
        # The window asks for the address of the VNA, too.
        doubtful = key == "address" and address.startswith("127.")
        allowed = "the four numbers of one device, such as 192.168.1.10"
        if reason:
            yield problem(file, key, address, reason, allowed, doubtful)
    for name, other in (ADDRESS_NAMES, ADDRESS_NAMES[::-1]):
        if named[name] and not named[other]:
            reason, allowed = f"two computers need both, and {other} is empty", "both, or none"
            yield problem("environment", name, named[name], reason, allowed, doubtful=True)


def _not_of_device(address: str) -> str:
    try:
        known = IPv4Address(address)
    except ValueError:
        return "this is no address"
    if known.is_loopback:
        return "this is the address of each computer for itself"
    usable = known.packed[0] and known.packed[0] < 224 and known.packed[3] not in (0, 255)
    return "" if usable else "no device can have this address"


def _unchecked(reading: Reading) -> Iterator[Problem]:
    wiring, file = reading.record("wiring"), reading.folder / WIRING_FILE
    for one in wiring.unchecked or ():
        reason = (
            "nobody has checked it; docs/coming_from_the_original.md describes how a person does, "
            "and with what"
        )
        allowed = "nothing in the list, once a person has checked it and corrected the files"
        where, doubtful = (file, "unchecked", one), one in get_args(WithRobot)
        yield problem(*where, reason, allowed, doubtful, faults.NOT_CHECKED)


def _extensions(reading: Reading, use: Use) -> Iterator[Problem]:
    """Find classes that cannot be used on the computer that needs them."""
    vna = reading.record("vna_acquisition")
    for axis, own in reading.axes().items():
        if own.controller and use.real and use.part != SERVER:
            # Imported only with a class of others: a launch without one need not wait for it.
            from gpr20_axis_driver.controller import check_controller

            file = reading.folder / AXES_FILE
            yield from _missing(file, f"{axis}/controller", check_controller, own)
    if is_extension(vna.analyzer) and use.real and use.part != ROBOT:
        from gpr20_vna_acquisition.mid.analyzers import has_passed, make_foreign_analyzer
        from gpr20_vna_acquisition.mid.exchanges import RequestDeadline

        deadline = RequestDeadline(Clock())
        file = reading.folder / ANALYZER_FILE
        missing = tuple(_missing(file, "analyzer", make_foreign_analyzer, vna, deadline))
        yield from missing
        if not missing and not has_passed(reading.folder, vna):
            reason = "it has not passed the check of analyzers as it is now"
            allowed = "run before a survey: rosrun gpr20_vna_acquisition check_analyzer"
            where = (file, "analyzer", vna.analyzer)
            yield problem(*where, reason, allowed, True, faults.NOT_CHECKED)


def _sensors(
    reading: Reading, use: Use, message_field: Callable[[str, str], object]
) -> Iterator[Problem]:
    own, file = reading.record(SENSORS), reading.folder / SENSORS_FILE
    seen: Dict[Tuple[str, str], str] = {}
    for number, one in enumerate(own.sensors):
        first, key = seen.setdefault((one.topic, one.field), one.name), f"{SENSORS}[{number}]"
        if first != one.name:
            reason = f"sensor {first} has this topic and field too, so both have one value"
            value, allowed = f"{one.topic} {one.field}", "a field of its own for each"
            yield problem(file, f"{key}/field", value, reason, allowed, doubtful=True)
        if use.part != ROBOT:
            yield from _missing(file, key, message_field, one.message, one.field)


def _missing(
    file: Path, key: str, check: Callable[..., object], *given: object
) -> Iterator[Problem]:
    try:
        check(*given)
    except Gpr20Error as error:
        text = Message(
            "{file}, {place}: {reason}; correct it, or install what it needs",
            file=printable(file),
            place=key,
            reason=error.message,
        )
        yield Problem(text.reporting_only(CONFIGURATION), str(file), key)
