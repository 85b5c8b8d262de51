"""Which software runs here."""

from __future__ import annotations

import subprocess
from pathlib import Path

import gpr20_common

TIME_LIMIT_S = 5.0
# Written when gpr20_common was installed: the git revision of the sources, or nothing.
INSTALLED_REVISION = Path(gpr20_common.__file__).resolve().with_name("installed_revision")


def git_revision(folder: Path, *options: str, installed: Path = INSTALLED_REVISION) -> str:
    """Return the git revision that was installed or is in a folder; empty if there is none.

    Args:
        folder: Where the sources are.
        options: Further options of `git describe`.
        installed: File with the revision that was installed.
    """
    if installed.exists():
        # Not that of a repository which the install space may be in.
        return installed.read_text(encoding="utf-8").strip()
    command = ["git", "-C", str(folder), "describe", "--always", "--tags", *options]
    try:
        answer = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT_S, check=True)
    except (OSError, subprocess.SubprocessError):
        # Installed without git, or not a checkout: only the version is known.
        return ""
    return answer.stdout.decode(errors="replace").strip()


def software_revision(version: str, folder: Path, installed: Path = INSTALLED_REVISION) -> str:
    """Return the version, with the git revision that was installed or is in the folder.

    Args:
        version: Version of the package.
        folder: Where the sources are.
        installed: File with the revision that was installed.
    """
    revision = git_revision(folder, "--dirty", installed=installed)
    return f"{version} (git {revision})" if revision else version
