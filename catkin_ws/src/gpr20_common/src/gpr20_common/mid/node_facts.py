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
    return NodeSoftware(gpr20_common.__version__, git_revision(), socket.gethostname())


def git_revision(*options: str) -> str:
    """Return the git revision that was installed, or that of the sources; empty if unknown."""
    if INSTALLED_REVISION.exists():  # not that of a repository which the install space may be in
        return INSTALLED_REVISION.read_text(encoding="utf-8").strip()
    folder = str(INSTALLED_REVISION.parent)
    command = ["git", "-C", folder, "describe", "--always", "--tags", *options]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""  # without git, or no checkout
    return answer.stdout.decode(errors="replace").strip()


def software_revision() -> str:
    """Return what a survey says of the software that stored it."""
    revision = git_revision("--dirty")
    return gpr20_common.__version__ + (f" (git {revision})" if revision else "")


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
