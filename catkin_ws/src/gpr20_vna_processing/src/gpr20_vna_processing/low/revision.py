"""Which software wrote a survey."""

from __future__ import annotations

import subprocess
from pathlib import Path

TIME_LIMIT_S = 5.0


def software_revision(version: str, folder: Path) -> str:
    """Return the version, with the git revision of a folder that is under git.

    Args:
        version: Version of the package.
        folder: Where the sources are.
    """
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--tags"]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        # Installed without git, or not a checkout: only the version is known.
        return version
    return f"{version} (git {answer.stdout.decode(errors='replace').strip()})"
