"""What the nodes of a robot drive, and which software they run."""

from __future__ import annotations

import socket
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Mapping, Optional

import gpr20_common
from gpr20_common import faults
from gpr20_common.message import Message, in_a_row

TIME_LIMIT_S = 5.0
# Written when gpr20_common was installed: the git revision of the sources, or nothing.
INSTALLED_REVISION = Path(gpr20_common.__file__).resolve().with_name("installed_revision")


@dataclass(frozen=True)
class Hardware:
    """What diagnostics and recordings call it, and how many times faster than real it runs."""

    name: str
    simulated: bool = False
    time_scale: float = 1.0


NO_HARDWARE = Hardware("")


@dataclass(frozen=True)
class NodeSoftware:
    """Which software a node runs, and on which computer; what is not known is empty."""

    version: str = ""
    revision: str = ""
    host: str = ""

    @property
    def name(self) -> str:
        return f"{self.version} ({self.revision})" if self.revision else self.version


def own_software() -> NodeSoftware:
    revision = git_revision(Path(__file__).resolve().parent)
    return NodeSoftware(gpr20_common.__version__, revision, socket.gethostname())


def git_revision(folder: Path, *options: str, installed: Path = INSTALLED_REVISION) -> str:
    """Return the git revision that was installed or is in a folder; empty if there is none."""
    if installed.exists():  # not that of a repository which the install space may be in
        return installed.read_text(encoding="utf-8").strip()
    command = ["git", "-C", str(folder), "describe", "--always", "--tags", *options]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""  # without git, or no checkout
    return answer.stdout.decode(errors="replace").strip()


def software_revision(version: str, folder: Path, installed: Path = INSTALLED_REVISION) -> str:
    """Return the version, with the git revision that was installed or is in the folder."""
    revision = git_revision(folder, "--dirty", installed=installed)
    return f"{version} (git {revision})" if revision else version


def software_difference(nodes: Mapping[str, NodeSoftware]) -> Optional[Message]:
    """Return which nodes run which software; None if all that say theirs run the same."""
    groups: Dict[str, List[str]] = {}
    for node, software in nodes.items():
        if software.version:
            groups.setdefault(software.name, []).append(node)
    if len(groups) < 2:
        return None
    found = in_a_row(
        Message(
            "{software} on {hosts}",
            software=name,
            hosts=", ".join(sorted({nodes[node].host or "?" for node in group})),
            details=f"{name}: {', '.join(sorted(group))}",
        )
        for name, group in sorted(groups.items())
    )
    text = Message("the parts of the robot run different software: {groups}", groups=found)
    return text.with_fault(faults.VERSIONS_DIFFER.as_warning())
