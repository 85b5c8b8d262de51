"""What the nodes of a robot drive, and which software they run."""

from __future__ import annotations

import socket
import subprocess
from dataclasses import dataclass
from pathlib import Path

import gpr20_common

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
    git = ["git", "-C", str(INSTALLED_REVISION.parent), "describe", "--always", "--tags", *options]
    try:
        answer = subprocess.run(git, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""  # without git, or no checkout
    return answer.stdout.decode(errors="replace").strip()


def software_revision() -> str:
    """Return what a survey says of the software that stored it."""
    revision = git_revision("--dirty")
    return gpr20_common.__version__ + (f" (git {revision})" if revision else "")
