"""How the window looks: its theme, and its sizes for the screen that it is on."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, NamedTuple

from PyQt5.QtWidgets import QWidget

from gpr20_operator.robot.condition import JobLevel
from gpr20_user_interface.look.settings import Theme


class ColourPair(NamedTuple):
    """Text and its background."""

    ink: str
    ground: str


class TextColours(enum.Enum):
    """Every pair of colours in which the window writes."""

    PLAIN = enum.auto()
    QUIET = enum.auto()
    WRONG = enum.auto()
    LOCKED = enum.auto()
    DISABLED = enum.auto()
    BUTTON = enum.auto()
    ARROW = enum.auto()
    CHOSEN = enum.auto()
    START = enum.auto()
    STOP = enum.auto()
    PRESSED = enum.auto()
    REPLAY = enum.auto()
    SIMULATED = enum.auto()
    ALARM = enum.auto()
    # The state of the robot: it works, it waits for the operator, it has failed, it is at rest.
    GOOD = enum.auto()
    DOUBTFUL = enum.auto()
    BAD = enum.auto()
    REST = enum.auto()
    # A survey that is not the one in progress.
    PAST = enum.auto()
    PROGRESS_EMPTY = enum.auto()
    PROGRESS_FULL = enum.auto()


class Mark(enum.Enum):
    """Every colour that is a line, an area or a mark, not text."""

    PAPER = enum.auto()
    INK = enum.auto()
    BORDER = enum.auto()
    GRID = enum.auto()
    STOP_MISSING = enum.auto()
    STOP_PARTLY = enum.auto()
    STOP_DONE = enum.auto()
    STOP_FAILED = enum.auto()
    CURRENT = enum.auto()
    CARRIAGE = enum.auto()
    SELECTED = enum.auto()
    CURVE = enum.auto()
    SURFACE = enum.auto()
    CANDIDATE = enum.auto()
    MARKER = enum.auto()
    NOT_MEASURED = enum.auto()


@dataclass(frozen=True)
class Palette:
    """The colours of a theme.

    Attributes:
        texts: Text and background; contrast at least 7:1 (WCAG 2.1, 1.4.6).
        marks: Lines and marks; contrast with the paper at least 3:1 (1.4.11).
    """

    texts: Dict[TextColours, ColourPair]
    marks: Dict[Mark, str]


_SUN = Palette(
    {
        TextColours.PLAIN: ColourPair("#111111", "#ffffff"),
        TextColours.QUIET: ColourPair("#444444", "#ffffff"),
        TextColours.WRONG: ColourPair("#8f0000", "#ffe3e3"),
        TextColours.LOCKED: ColourPair("#333333", "#e8e8e8"),
        TextColours.DISABLED: ColourPair("#444444", "#dddddd"),
        TextColours.BUTTON: ColourPair("#ffffff", "#1f4e8c"),
        TextColours.ARROW: ColourPair("#111111", "#d5e3f5"),
        TextColours.CHOSEN: ColourPair("#ffffff", "#0b3160"),
        TextColours.START: ColourPair("#ffffff", "#155425"),
        TextColours.STOP: ColourPair("#ffffff", "#a80000"),
        TextColours.PRESSED: ColourPair("#111111", "#ffd400"),
        TextColours.REPLAY: ColourPair("#ffffff", "#084f96"),
        TextColours.SIMULATED: ColourPair("#111111", "#ffd400"),
        TextColours.ALARM: ColourPair("#ffffff", "#8f0000"),
        TextColours.GOOD: ColourPair("#ffffff", "#155425"),
        TextColours.DOUBTFUL: ColourPair("#111111", "#ffb300"),
        TextColours.BAD: ColourPair("#ffffff", "#a80000"),
        TextColours.REST: ColourPair("#111111", "#e4e4e4"),
        TextColours.PAST: ColourPair("#ffffff", "#5b2a86"),
        TextColours.PROGRESS_EMPTY: ColourPair("#111111", "#f2f2f2"),
        TextColours.PROGRESS_FULL: ColourPair("#111111", "#9cc9f5"),
    },
    {
        Mark.PAPER: "#ffffff",
        Mark.INK: "#111111",
        Mark.BORDER: "#555555",
        Mark.GRID: "#777777",
        Mark.STOP_MISSING: "#777777",
        Mark.STOP_PARTLY: "#4a90d9",
        Mark.STOP_DONE: "#10336a",
        Mark.STOP_FAILED: "#c94200",
        Mark.CURRENT: "#8a6d00",
        Mark.CARRIAGE: "#000000",
        Mark.SELECTED: "#c000c0",
        Mark.CURVE: "#1f4e8c",
        Mark.SURFACE: "#a80000",
        Mark.CANDIDATE: "#a80000",
        Mark.MARKER: "#5b2a86",
        Mark.NOT_MEASURED: "#8c8c8c",
    },
)

_NIGHT = Palette(
    {
        TextColours.PLAIN: ColourPair("#e6e6e6", "#101418"),
        TextColours.QUIET: ColourPair("#b4bcc4", "#101418"),
        TextColours.WRONG: ColourPair("#ffc9c9", "#4a0f0f"),
        TextColours.LOCKED: ColourPair("#c8ced4", "#22292f"),
        TextColours.DISABLED: ColourPair("#b2bac2", "#22282e"),
        TextColours.BUTTON: ColourPair("#ffffff", "#23507f"),
        TextColours.ARROW: ColourPair("#f0f0f0", "#2b3d50"),
        TextColours.CHOSEN: ColourPair("#101418", "#8fc1f0"),
        TextColours.START: ColourPair("#ffffff", "#155425"),
        TextColours.STOP: ColourPair("#ffffff", "#a80000"),
        TextColours.PRESSED: ColourPair("#111111", "#ffd400"),
        TextColours.REPLAY: ColourPair("#ffffff", "#084f96"),
        TextColours.SIMULATED: ColourPair("#111111", "#e0bb00"),
        TextColours.ALARM: ColourPair("#ffffff", "#8f0000"),
        TextColours.GOOD: ColourPair("#ffffff", "#155425"),
        TextColours.DOUBTFUL: ColourPair("#111111", "#ffb300"),
        TextColours.BAD: ColourPair("#ffffff", "#a80000"),
        TextColours.REST: ColourPair("#e6e6e6", "#2a3138"),
        TextColours.PAST: ColourPair("#ffffff", "#5b2a86"),
        TextColours.PROGRESS_EMPTY: ColourPair("#e6e6e6", "#1b2126"),
        TextColours.PROGRESS_FULL: ColourPair("#ffffff", "#23507f"),
    },
    {
        Mark.PAPER: "#101418",
        Mark.INK: "#e6e6e6",
        Mark.BORDER: "#8a949e",
        Mark.GRID: "#707a84",
        Mark.STOP_MISSING: "#8a949e",
        Mark.STOP_PARTLY: "#46739f",
        Mark.STOP_DONE: "#c4e2ff",
        Mark.STOP_FAILED: "#ff7a33",
        Mark.CURRENT: "#ffd400",
        Mark.CARRIAGE: "#ffffff",
        Mark.SELECTED: "#ff6cff",
        Mark.CURVE: "#8fc1f0",
        Mark.SURFACE: "#ff6b6b",
        Mark.CANDIDATE: "#ff6b6b",
        Mark.MARKER: "#c79bf0",
        Mark.NOT_MEASURED: "#737b83",
    },
)

PALETTES: Dict[Theme, Palette] = {Theme.SUN: _SUN, Theme.NIGHT: _NIGHT}


# Every size is written for this screen, and scaled for another one.
DESIGN_WIDTH_PX = 800
DESIGN_HEIGHT_PX = 480
# A screen of 480x320, less the frame of a window.
SMALLEST_SCALE = 0.57
LARGEST_SCALE = 1.8

# What a gloved finger hits: 60 pixels are 11 mm on a 7 inch screen of 800x480.
TOUCH_PX = 60
COMMAND_PX = 72
GAP_PX = 8
TEXT_PX = 18
TITLE_PX = 22
BORDER_PX = 2
TOP_BAR_PX = 68


@dataclass(frozen=True)
class Look:
    """A theme and a scale.

    Attributes:
        theme: The colours.
        scale: Size of everything; 1.0 on a screen of 800x480.
    """

    theme: Theme = Theme.SUN
    scale: float = 1.0

    def px(self, design_px: float) -> int:
        """Return a size of the design on this screen; at least one pixel."""
        return max(1, round(design_px * self.scale))

    def text(self, colours: TextColours) -> ColourPair:
        """Return a text's colours."""
        return PALETTES[self.theme].texts[colours]

    def colour(self, mark: Mark) -> str:
        """Return the colour of a line or mark."""
        return PALETTES[self.theme].marks[mark]


def scale_for(width_px: int, height_px: int) -> float:
    """Return the scale at which the design fills a screen."""
    scale = min(width_px / DESIGN_WIDTH_PX, height_px / DESIGN_HEIGHT_PX)
    return min(max(scale, SMALLEST_SCALE), LARGEST_SCALE)


def look_of(widget: QWidget) -> Look:
    """Return the look of the window that a widget is in; the default before it is in one."""
    found = getattr(widget.window(), "look", None)
    return found if isinstance(found, Look) else Look()


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
