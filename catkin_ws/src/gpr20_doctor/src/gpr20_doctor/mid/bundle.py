"""One JSON file with what somebody far away needs to help.

Nothing enters it but what this module lists: sentences of the software with their numbers, values
of named keys, and words of logs in known forms. A secret has no place among them, however it is
written.
"""

from __future__ import annotations

import functools
import json
import os
import platform
import re
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Mapping, Tuple

from gpr20_common.catalogue import FOLDER, read_translations
from gpr20_common.low.yaml_file import read_yaml
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low.processes import FAILURES
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.folder.survey_folder import LOG_FILE

ABOUT = (
    "GPR-20: file for remote help. Only what is known to hold no secret is in it: no names of "
    "people, no positions, no addresses, no passwords, nothing that somebody wrote. `missing` "
    "names what could not be collected."
)
FILES = ("axes", "height", "analyzer", "survey", "storage", "sensors", "site", "web", "wiring")
# Of these files: the axes, and what is a number or one of a few words.
KEYS = frozenset(
    re.findall(
        r"\w+",
        """x y z dir_pin step_pin sensor_pin enable_pin enable_active step_size min_step max_step
    delta_step min_coord max_coord type homing_backoff homing_margin endstop_active endstop_pull
    invert_direction late_limit_s gap_limit_s lease_limit_s
    spi_bus spi_device spi_speed_hz channel reference_voltage_v scale_m exponent min_distance_m
    max_distance_m height_offset_m samples update_period_s max_spread_m frozen_readings
    publish_rate_hz
    vxi11_port connect_timeout_s answer_timeout_s clear_on_connect lock_instrument display_settle_s
    settle_s seconds_per_point sweep_timeout_s request_timeout_s attempts retry_pause_s link_check_s
    transfer_format min_frequency_hz max_frequency_hz min_level_db max_level_db antenna_delay_ns
    height_s on_height_failure return_limit_s repeat_limit_db reference_interval_s drift_limit_db
    drift_limit_deg
    data_disk disk_reserve_mb message_queue_mb timeout_s long_timeout_s commit_period_s
    false_alarms_per_m2 port session_hours unchecked accepted_calibrations
    readable_by""",
    )
)
# Of a sentence about the configuration: a file, a key and its number.
PLACES = re.compile(
    rf"\b(?:{'|'.join(FILES)})\.yaml\b"
    rf"|\b(?:[xyz]/)?(?:{'|'.join(sorted(KEYS))})\b(?: is -?\d[\d.e-]{{0,12}}(?=[;: ]|$))?"
)
# Such as LIN.
CHOICE = re.compile(r"[A-Za-z_]{1,16}")
# No address of a network.
NUMBER = re.compile(r"-?\d{1,12}(\.\d{1,12})?")
# Of a log: program, level and time; a place in the software; the class of an error; how a part
# ended.
LOG_WORDS = re.compile(
    r"\[[\w./-]{1,60}\]\[(?:WARN|WARNING|ERROR|FATAL|CRITICAL)\] [\d-]{10} [\d:,]{8,12}"
    r"|(?<=/)gpr20_\w+/[\w/]+\.py\", line \d+, in \w+"
    r"|^[A-Z]\w{1,40}(?:Error|Exception|Interrupt)(?=:|$)"
    r"|\[[\w/-]{1,60}\] process has (?:died|finished)[^,\n]{0,20}, exit code -?\d+",
    re.MULTILINE,
)
# What a sentence of the software begins with has so many characters, or could be anybody's.
BEGINNING, LONGEST = 12, 300
# Of the log of a survey: number, time, kind and faults of each fact.
FACT_WORDS = re.compile(
    r'"number":\d{1,7}|"time":"[\dT:.+Z-]{1,40}"|"kind":"[a-z_]{1,20}"'
    r'|"code":"[a-z_]{1,30}\.[a-z_]{1,40}"'
)
PART_BYTES, LOG_FILES = 1 << 20, 100
# The robot's own work comes first.
NICENESS = 19


def write_bundle(
    path: Path, found: Tuple[Finding, ...], robot: RobotFacts, machine: Machine
) -> Dict[str, str]:
    """Write the bundle; return which parts are missing, and why.

    Args:
        path: The file, which must not exist.
        found: What the doctor found.
        robot: What the nodes report.
        machine: Where things are on this computer.

    Raises:
        OSError: The file exists, or cannot be written; nothing of it is left.
    """
    os.nice(NICENESS)
    parts: Dict[str, Any] = {"about": ABOUT}
    missing: Dict[str, str] = {}
    for name, content in _parts(found, robot, machine):
        try:
            text = content()
            if text:  # a log without an error says nothing
                parts[name] = text
        except FAILURES as error:
            missing[name] = type(error).__name__
    with path.open("x", encoding="utf-8") as file:
        try:
            json.dump({**parts, "missing": missing}, file, indent=1)
            file.flush()
            os.fsync(file.fileno())
        except BaseException:
            path.unlink()
            raise
    return missing


def _parts(
    found: Tuple[Finding, ...], robot: RobotFacts, machine: Machine
) -> Iterator[Tuple[str, Callable[[], Any]]]:
    nothing: Mapping[str, str] = {}
    findings = [(one.check, one.level.name, one.text, nothing) for one in found]
    nodes = [(one.name, one.level.name, one.message, one.values) for one in robot.nodes]
    yield "findings", lambda: [_said(*one) for one in findings]
    yield "diagnostics", lambda: [_said(*one) for one in nodes]
    yield "versions", lambda: _versions(robot, machine.root)
    yield "survey", lambda: _survey(machine)
    # A file that is not there has the defaults.
    for path in filter(Path.exists, (machine.config / f"{name}.yaml" for name in FILES)):
        yield path.name, partial(_configuration, path)
    for number, path in enumerate(_newest(machine.log, "**/*.log")[:LOG_FILES]):
        yield f"log {number}", partial(_errors, path)


def _said(name: str, level: str, message: Message, values: Mapping[str, str]) -> Dict[str, Any]:
    """Return what was said, by the templates of the software and with numbers and keys alone."""
    inside = [item for sentence in message.nested() for item in sentence.values.items()]
    numbers: Dict[str, Any] = {key: one for key, one in inside if isinstance(one, (int, float))}
    numbers.update({key: one for key, one in values.items() if NUMBER.fullmatch(one)})
    about_files = [one for _key, one in inside if isinstance(one, str) and ".yaml" in one]
    return {
        "name": name,
        "level": level,
        "code": message.fault_code,
        # One that came from elsewhere may be anything.
        "said": [one.template for one in message.nested() if one.template in _templates()],
        "numbers": numbers,
        "places": [place for one in about_files for place in PLACES.findall(one)],
    }


def _templates() -> Mapping[str, str]:
    return read_translations(FOLDER / "es.po")


@functools.lru_cache(maxsize=None)
def _beginnings() -> Mapping[str, str]:
    """Return the templates of the software by what is before the first value of each."""
    known = {one.partition("{")[0]: one for one in _templates()}
    return {begin: one for begin, one in known.items() if len(begin) >= BEGINNING}


def _errors(path: Path) -> List[str]:
    """Return of each error at the end of a log what `LOG_WORDS` finds, and its template."""
    found = []
    for line in _end(path).splitlines():
        words = [one.group() for one in LOG_WORDS.finditer(line)]
        pieces = line[:LONGEST].split(": ") if words else ()
        begins = (one[:end] for one in pieces for end in range(len(one), BEGINNING - 1, -1))
        found += [*words, *(_beginnings()[one] for one in begins if one in _beginnings())]
    return found


def _configuration(path: Path) -> Any:
    return listed(read_yaml(path))


def listed(value: Any) -> Any:
    """Return those values of a file that have a listed key, and are a number or a choice."""
    if isinstance(value, dict):
        return {key: listed(one) for key, one in value.items() if key in KEYS}
    if isinstance(value, list):
        return [one for one in map(listed, value) if one is not None]
    is_choice = isinstance(value, str) and CHOICE.fullmatch(value)
    return value if is_choice or isinstance(value, (int, float)) else None


def _versions(robot: RobotFacts, root: Path) -> Dict[str, Any]:
    model = root / "proc/device-tree/model"
    return {
        "installed": own_software().name,
        "parts": {name: one.name for name, one in robot.software.items()},
        "python": platform.python_version(),
        "system": platform.platform(),
        "model": model.read_text().strip("\0") if model.exists() else "",
    }


def _survey(machine: Machine) -> List[str]:
    logs = [] if machine.data is None else _newest(machine.data, f"*/{LOG_FILE}")
    if not logs:
        raise FileNotFoundError("no survey")
    return [one.group() for one in FACT_WORDS.finditer(_end(logs[0]))]


def _newest(folder: Path, pattern: str) -> List[Path]:
    """Return regular files below a folder, the newest first."""
    found = filter(Path.is_file, folder.glob(pattern))
    return sorted(found, key=lambda one: one.stat().st_mtime, reverse=True)


def _end(path: Path) -> str:
    with path.open("rb") as stream:
        stream.seek(max(0, os.fstat(stream.fileno()).st_size - PART_BYTES))
        return stream.read(PART_BYTES).decode(errors="replace")
