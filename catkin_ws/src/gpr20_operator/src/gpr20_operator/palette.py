"""The colours of every screen of the operator, for sunlight and for the night."""

from __future__ import annotations

import enum
from typing import Dict, NamedTuple

from gpr20_operator.robot.condition import JobLevel


class Theme(enum.Enum):
    """Where a screen is read: in sunlight, or in the dark without dazzling."""

    SUN = "sun"
    NIGHT = "night"


class ColourPair(NamedTuple):
    """Text and its background."""

    ink: str
    ground: str


@enum.unique
class TextColours(enum.Enum):
    """Every pair of colours in which a screen writes: ink and ground, in the sun and at night.

    Their contrast is at least 7:1 (WCAG 2.1, 1.4.6).
    """

    PLAIN = "#111111 #ffffff", "#e6e6e6 #101418"
    QUIET = "#444444 #ffffff", "#b4bcc4 #101418"
    WRONG = "#8f0000 #ffe3e3", "#ffc9c9 #4a0f0f"
    LOCKED = "#333333 #e8e8e8", "#c8ced4 #22292f"
    DISABLED = "#444444 #dddddd", "#b2bac2 #22282e"
    # The primary colour: what is done most on a page.
    BUTTON = "#ffffff #1f4e8c", "#ffffff #23507f"
    # Every other button.
    ARROW = "#111111 #d5e3f5", "#f0f0f0 #2b3d50"
    CHOSEN = "#ffffff #0b3160", "#101418 #8fc1f0"
    PRESSED = "#111111 #ffd400", "#111111 #ffd400"
    REPLAY = "#ffffff #084f96", "#ffffff #084f96"
    SIMULATED = "#111111 #ffd400", "#111111 #e0bb00"
    ALARM = "#ffffff #8f0000", "#ffffff #8f0000"
    # The robot works, waits for the operator, has failed, is at rest. Also START and STOP.
    GOOD = "#ffffff #155425", "#ffffff #155425"
    DOUBTFUL = "#111111 #ffb300", "#111111 #ffb300"
    BAD = "#ffffff #a80000", "#ffffff #a80000"
    REST = "#111111 #e4e4e4", "#e6e6e6 #2a3138"
    # A survey that is not the one in progress.
    PAST = "#ffffff #5b2a86", "#ffffff #5b2a86"
    PROGRESS_EMPTY = "#111111 #f2f2f2", "#e6e6e6 #1b2126"
    PROGRESS_FULL = "#111111 #9cc9f5", "#ffffff #23507f"

    def of(self, theme: Theme) -> ColourPair:
        """Return text and background in a theme."""
        return ColourPair(*self.value[theme is Theme.NIGHT].split())


@enum.unique
class Mark(enum.Enum):
    """Every colour that is a line, an area or a mark, not text; in the sun and at night.

    Their contrast with the paper is at least 3:1 (WCAG 2.1, 1.4.11).
    """

    PAPER = "#ffffff", "#101418"
    INK = "#111111", "#e6e6e6"
    BORDER = "#555555", "#8a949e"
    GRID = "#777777", "#707a84"
    STOP_MISSING = "#777777", "#8a949e"
    STOP_PARTLY = "#4a90d9", "#46739f"
    STOP_DONE = "#10336a", "#c4e2ff"
    STOP_FAILED = "#c94200", "#ff7a33"
    CURRENT = "#8a6d00", "#ffd400"
    CARRIAGE = "#000000", "#ffffff"
    SELECTED = "#c000c0", "#ff6cff"
    CURVE = "#1f4e8c", "#8fc1f0"
    SURFACE = "#a80000", "#ff6b6b"
    CANDIDATE = "#a80000", "#ff7070"
    MARKER = "#5b2a86", "#c79bf0"
    NOT_MEASURED = "#8c8c8c", "#737b83"

    def of(self, theme: Theme) -> str:
        """Return the colour in a theme."""
        return str(self.value[theme is Theme.NIGHT])


# Of the state of the job.
LEVEL_COLOURS: Dict[JobLevel, TextColours] = {
    JobLevel.WORKING: TextColours.GOOD,
    JobLevel.PAUSED: TextColours.DOUBTFUL,
    JobLevel.ATTENTION: TextColours.DOUBTFUL,
    JobLevel.FAULT: TextColours.BAD,
    JobLevel.DONE: TextColours.PROGRESS_FULL,
    JobLevel.REST: TextColours.REST,
    JobLevel.REPLAY: TextColours.REPLAY,
}
