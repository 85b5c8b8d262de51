"""Which software runs here."""

from __future__ import annotations

import subprocess
from pathlib import Path

TIME_LIMIT_S = 5.0


def git_revision(folder: Path, *options: str) -> str:
    """Return the git revision of a folder; empty if it is not under git.

    Args:
        folder: Where the sources are.
        options: Further options of `git describe`.
    """
    command = ["git", "-C", str(folder), "describe", "--always", "--tags", *options]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        # Installed without git, or not a checkout: only the version is known.
        return ""
    return answer.stdout.decode(errors="replace").strip()


def software_revision(version: str, folder: Path) -> str:
    """Return the version, with the git revision of a folder that is under git.

    Args:
        version: Version of the package.
        folder: Where the sources are.
    """
    revision = git_revision(folder, "--dirty")
    return f"{version} (git {revision})" if revision else version
