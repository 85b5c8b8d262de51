"""The groups of a user."""

from __future__ import annotations

import os
import pwd
from pathlib import Path
from typing import Dict, FrozenSet, Sequence, Tuple

GROUP_FILE = Path("etc/group")


def user_name() -> str:
    """Return the name of the user of this process; its number if it has no name."""
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())


def group_names(root: Path) -> Dict[int, str]:
    """Return the groups of a computer by their numbers.

    Raises:
        OSError: They cannot be read.
    """
    return {number: name for name, number, _users in _entries(root)}


def groups_listing(root: Path, user: str) -> FrozenSet[str]:
    """Return the groups that list a user.

    Raises:
        OSError: They cannot be read.
    """
    return frozenset(name for name, _number, users in _entries(root) if user in users)


def _entries(root: Path) -> Sequence[Tuple[str, int, Sequence[str]]]:
    entries = []
    text = (root / GROUP_FILE).read_text(encoding="utf-8", errors="replace")
    for line in text.splitlines():
        fields = line.split(":")
        if len(fields) == 4 and fields[2].isdigit():
            entries.append((fields[0], int(fields[2]), fields[3].split(",")))
    return entries
