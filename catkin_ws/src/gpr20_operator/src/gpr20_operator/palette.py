"""How every screen is painted, in sunlight and at night: colours, patterns of cells, shades.

A picture has a number per pixel, and a table has the colour of each number.
"""

from __future__ import annotations

import enum
from functools import lru_cache
from typing import Dict, NamedTuple, Tuple

import numpy as np

from gpr20_operator.ground.coverage import Cell
from gpr20_operator.ground.grid import Area
from gpr20_operator.robot.condition import JobLevel
from gpr20_survey.results.hiding_map import MM_PER_M, HidingMap

# The number of a shade, or this one where nothing was measured.
NOT_MEASURED = 255
LAST_SHADE = NOT_MEASURED - 1
# From noise to the strongest echo: a part of viridis of matplotlib, which becomes evenly brighter.
SHADES = "440154 482878 3e4a89 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725"
# What is written over a dark picture, in both themes.
NOTICE_INK, NOTICE_GROUND = "#ffffff", "#2b0138"
# Of the depths that were tried: what is missed above that is hatched densely.
DENSE_SHARE = 0.5
# Width and height of a pattern, which is repeated [px].
TILE_PX = 16
# Longer side of a picture of cells at most, and of a cell at most, and with lines at least [px].
MOST_PX, MOST_CELL_PX, LINED_CELL_PX = 1024, 64, 7


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


def _no(mark: Mark) -> int:
    """Return the number of a mark in a picture; 0: none."""
    return MARKS.index(mark) + 1


def _tiles() -> np.ndarray:
    """Return the numbers of each pattern (uint8, cells x TILE_PX x TILE_PX)."""
    y, x = np.mgrid[:TILE_PX, :TILE_PX]
    rising, falling, paper = (x + y) % 8, (x - y) % 8, _no(Mark.PAPER)
    tiles = np.zeros((len(Cell), TILE_PX, TILE_PX), np.uint8)
    # Missing: empty, with dots.
    tiles[Cell.MISSING] = np.where((x % 8 < 2) & (y % 8 < 2), _no(Mark.STOP_MISSING), paper)
    # Partly: half of it is done. Failed: a lattice.
    tiles[Cell.PARTLY] = np.where(rising < 4, _no(Mark.STOP_DONE), _no(Mark.STOP_PARTLY))
    tiles[Cell.DONE] = _no(Mark.STOP_DONE)
    tiles[Cell.FAILED] = np.where(np.minimum(rising, falling) < 2, paper, _no(Mark.STOP_FAILED))
    # Over whatever is below, so each line has a rim: dashes and diagonals.
    for cell, line in (
        (Cell.LOADING, np.where(x < 11, y % 8, TILE_PX)),
        (Cell.HIDING, (x + y) % 16),
        (Cell.HIDING_SHALLOW, rising),
    ):
        tiles[cell] = np.select([line < 2, line < 4], [_no(Mark.INK), paper], 0)
    return tiles


MARKS = tuple(Mark)
TILES = _tiles()


def pattern(cells: np.ndarray, room_px: float, lined: bool = False) -> np.ndarray:
    """Return the numbers of a picture of cells, about as large as its room.

    Args:
        cells: Cell of each place (uint8, both axes ascending).
        room_px: Longer side of the room.
        lined: Whether there are lines between large cells.
    """
    px = int(np.clip(round(min(room_px, MOST_PX) / max(cells.shape)), 1, MOST_CELL_PX))
    # The first row of a picture is the one at the top.
    wide = cells[::-1].repeat(px, axis=0).repeat(px, axis=1)
    y, x = (np.arange(size) % TILE_PX for size in wide.shape)
    numbers: np.ndarray = TILES[wide, y[:, None], x]
    if lined and px >= LINED_CELL_PX:
        numbers[::px] = numbers[:, ::px] = _no(Mark.GRID)
    return numbers


@lru_cache(maxsize=None)
def pattern_colours(theme: Theme) -> np.ndarray:
    """Return red, green, blue and alpha of the numbers of patterns (uint8, n x 4)."""
    colours = [bytes(4), *(bytes.fromhex(one.of(theme)[1:]) + b"\xff" for one in MARKS)]
    return np.array([list(one) for one in colours], np.uint8)


def hiding_cells(found: HidingMap) -> Tuple[np.ndarray, Area]:
    """Return the Cell of each place where a target could hide, and the area of the map."""
    missed_m = found.missed_m
    hidden = np.isfinite(missed_m)
    deeper = np.mean(found.depth_m[:, None, None] < np.where(hidden, missed_m, 0.0), axis=0)
    cells = np.where(deeper < DENSE_SHARE, Cell.HIDING_SHALLOW, Cell.HIDING)
    (width, height), x, y = found.cell_m, found.x_m, found.y_m
    ends = (x[0] - width / 2, x[-1] + width / 2, y[0] - height / 2, y[-1] + height / 2)
    area = Area(*(MM_PER_M * float(one) for one in ends))
    return np.where(hidden, cells, Cell.BLANK).astype(np.uint8), area


@lru_cache(maxsize=None)
def shade_colours() -> np.ndarray:
    """Return red, green, blue and alpha of the numbers of shades (uint8, 256 x 4).

    What was not measured is transparent.
    """
    stops = np.array([list(bytes.fromhex(one)) for one in SHADES.split()], np.float64)
    places = np.linspace(0.0, len(stops) - 1.0, LAST_SHADE + 1)
    table = np.zeros((NOT_MEASURED + 1, 4), np.uint8)
    for channel in range(3):
        found = np.interp(places, np.arange(len(stops)), stops[:, channel])
        table[: LAST_SHADE + 1, channel] = np.rint(found)
    table[: LAST_SHADE + 1, 3] = 255
    return table


def shade_numbers(shades: np.ndarray) -> np.ndarray:
    """Return the number of each shade, which is 0 to 1, or NaN where nothing was measured."""
    measured = np.isfinite(shades)
    numbers = np.rint(np.where(measured, shades, 0.0) * LAST_SHADE).astype(np.uint8)
    numbers[~measured] = NOT_MEASURED
    return numbers
