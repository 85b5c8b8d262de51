"""One ZIP file with what somebody far away needs to help; no traces and no secrets."""

from __future__ import annotations

import json
import os
import platform
import sys
import zipfile
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low.bundle_sources import (
    COMMANDS,
    end_of,
    json_without_secrets,
    newest,
    without_secrets,
)
from gpr20_doctor.low.programs import answer_of
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import as_json, lines
from gpr20_doctor.mid.machine_request import MachineRequest
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_survey.folder.survey_folder import LOG_FILE, SURVEY_FILE

# Other files of the folder, such as the signing key, are never opened.
CONFIGURATION = tuple(
    f"{name}.yaml"
    for name in (
        *("axes", "height", "analyzer", "survey", "storage", "sensors", "site", "web", "wiring"),
    )
)
PART_BYTES, SURVEY_BYTES = 1 << 20, 8 << 20
LIMIT_S = 10.0
LOGS_BYTES, LOG_FILES = 8 << 20, 100
# The robot's own work comes first.
NICENESS = 19
README = """GPR-20: bundle for remote help

findings.txt, findings.json   what the doctor found, the worst first
diagnostics.json              what each part of the robot reported
versions.json                 software, Python, system and model of this computer
configuration/                the robot's configuration and the settings of the services
survey/                       the last survey: survey.json, list of files, end of its log; no traces
logs/                         ROS logs, the newest first, at most 8 MB; journal of the services
system/                       packages, disks, memory, processes, network, clock, firewall
index.json                    every part, and each that could not be collected, with the reason

Left out: the signing key, and the values of what is called password, secret, token, key, cookie or
options, and the like. Still in it: names of operators, positions of site and survey, network
addresses. Look through it before you send it where they must not be known.
"""


class Bundle:
    """Collects the parts; one that fails is named in the index, and the others follow."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._parts: List[str] = []
        self._missing: Dict[str, str] = {}

    def add(self, name: str, content: Callable[..., str], *arguments: Any) -> int:
        """Add one part; return its size [characters], 0 if it could not be collected.

        Args:
            name: Of the part.
            content: Returns its text.
            arguments: Of that function.
        """
        try:
            text = content(*arguments)
            clean = json_without_secrets if name.endswith(".json") else without_secrets
            text = clean(text)
        except (OSError, Gpr20Error, ValueError) as error:
            self._missing[name] = str(error) or type(error).__name__
            return 0
        self._archive.writestr(name, text)
        self._parts.append(name)
        return len(text)

    def lack(self, name: str, reason: str) -> None:
        """Note a part that is not there."""
        self._missing[name] = reason

    def finish(self) -> Dict[str, str]:
        """Write the index; return what is missing, and why."""
        index = {"parts": self._parts, "missing": self._missing}
        self._archive.writestr("index.json", json.dumps(index, indent=2, ensure_ascii=False))
        return self._missing


def write_bundle(
    path: Path, found: Tuple[Finding, ...], robot: RobotFacts, request: MachineRequest
) -> Dict[str, str]:
    """Write the bundle; return which parts are missing, and why.

    Args:
        path: The file, which must not exist.
        found: What the doctor found.
        robot: What the nodes report.
        request: Where things are on this computer.

    Raises:
        OSError: The file exists, or cannot be written; nothing of it is left.
    """
    os.nice(NICENESS)
    with path.open("xb") as file:
        try:
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
                missing = _collect(Bundle(archive), found, robot, request)
            file.flush()
            os.fsync(file.fileno())
        except BaseException:
            path.unlink()
            raise
    return missing


def _collect(
    bundle: Bundle, found: Tuple[Finding, ...], robot: RobotFacts, request: MachineRequest
) -> Dict[str, str]:
    english = Catalogue()
    bundle.add("README.txt", str, README)
    bundle.add("findings.json", as_json, found, english)
    bundle.add("findings.txt", lambda: "\n".join(lines(found, english)))
    bundle.add("versions.json", _versions, robot, request.root)
    bundle.add("diagnostics.json", _diagnostics, robot)
    for name in CONFIGURATION:
        path = request.place.config / name
        bundle.add(f"configuration/{name}", end_of, path, PART_BYTES, True)
    if request.place.settings is None:
        bundle.lack("configuration/environment", "no packages of services are installed here")
    else:
        bundle.add("configuration/environment", end_of, request.place.settings, PART_BYTES, True)
    _add_survey(bundle, request.data)
    for name, command in COMMANDS:
        bundle.add(name, lambda words: answer_of(words, LIMIT_S, None)[-PART_BYTES:], command)
    _add_logs(bundle, request.place.log)
    return bundle.finish()


def _versions(robot: RobotFacts, root: Path) -> str:
    model = root / "proc/device-tree/model"
    return json.dumps(
        {
            "installed": own_software().name,
            "parts": {name: f"{one.name} {one.host}" for name, one in robot.software.items()},
            "python": sys.version,
            "kernel": platform.release(),
            "machine": platform.machine(),
            "model": model.read_text(errors="replace").strip("\0") if model.exists() else "",
            "system": (root / "etc/os-release").read_text(errors="replace").splitlines(),
            "ros": os.environ.get("ROS_DISTRO", ""),
        },
        indent=2,
    )


def _diagnostics(robot: RobotFacts) -> str:
    if not robot.nodes:
        raise ValueError("no part of the robot reports")
    nodes = [
        {
            "node": one.name,
            "level": one.level.name,
            "text": str(one.message),
            "fault_code": one.message.fault_code,
            "values": dict(one.values),
        }
        for one in robot.nodes
    ]
    return json.dumps(nodes, indent=2, ensure_ascii=False)


def _add_survey(bundle: Bundle, data: Optional[Path]) -> None:
    surveys = [] if data is None else newest(data, f"*/{SURVEY_FILE}")
    if not surveys:
        where = "on this computer" if data is None else f"in {data}"
        bundle.lack("survey", f"there is no survey {where}")
        return
    folder = surveys[0].parent
    sizes = {SURVEY_FILE: SURVEY_BYTES, MANIFEST_FILE: SURVEY_BYTES, LOG_FILE: PART_BYTES}
    for name, most_bytes in sizes.items():
        bundle.add(f"survey/{folder.name}/{name}", end_of, folder / name, most_bytes)


def _add_logs(bundle: Bundle, folder: Path) -> None:
    logs = newest(folder, "**/*.log")
    if not logs:
        bundle.lack("logs", f"there is no log in {folder}")
    left = LOGS_BYTES
    for number, path in enumerate(logs):
        if left < PART_BYTES or number == LOG_FILES:
            bundle.lack("logs", f"{len(logs) - number} older ones: the bundle has its limit")
            break
        name = f"logs/{path.relative_to(folder)}"
        left -= bundle.add(name, end_of, path, PART_BYTES)
