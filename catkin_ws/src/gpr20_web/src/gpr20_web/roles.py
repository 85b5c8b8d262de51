"""Who may what on the page."""

from __future__ import annotations

import enum


class Role(enum.IntEnum):
    """What a person may do; each role may do all of those before it."""

    NOBODY = 0
    """Not logged in."""
    VIEW = 1
    """Watches, adds notes and markers, pauses and stops."""
    OPERATE = 2
    """Also starts and resumes, while somebody at the robot allows it."""

    @property
    def word(self) -> str:
        """What it is called in files and on the command line."""
        return self.name.lower()
