"""Which software wrote a survey."""

from __future__ import annotations

import subprocess
from pathlib import Path

TIME_LIMIT_S = 5.0
# CMakeLists.txt writes it into the installed package: the git revision of the sources, or nothing.
INSTALLED_REVISION = "installed_revision"


def software_revision(version: str, package: Path) -> str:
    """Return the version, with the git revision of the sources where they were under git.

    Args:
        version: Version of the package.
        package: Folder of the Python package, in the sources or installed.
    """
    try:
        # An install space may be in the git repository of something else.
        revision = (package / INSTALLED_REVISION).read_text(encoding="utf-8").strip()
    except OSError:
        revision = _git_revision(package)
    return f"{version} (git {revision})" if revision else version


def _git_revision(folder: Path) -> str:
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--tags"]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        # No git here, or not a checkout: only the version is known.
        return ""
    return answer.stdout.decode(errors="replace").strip()
