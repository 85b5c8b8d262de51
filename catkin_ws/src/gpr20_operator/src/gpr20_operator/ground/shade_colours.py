"""Colours of the shades of a picture."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gpr20_operator.ground.records import Colours

# A picture has a number per pixel: that of a shade, or this one where nothing was measured.
NOT_MEASURED = 255
LAST_SHADE = NOT_MEASURED - 1
# What is written over a dark picture, in both themes.
NOTICE_INK, NOTICE_GROUND = "#ffffff", "#2b0138"

# From noise to the strongest echo, or from the most negative wave to the most positive one. The
# first row is a part of viridis of matplotlib, which becomes evenly brighter.
_STOPS = {
    Colours.ENVELOPE: "440154 482878 3e4a89 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725",
    Colours.GREY: "000000 808080 ffffff",
    Colours.RED_WHITE_BLUE: "0b2a8f 4d79d6 ffffff d65a4d 8f0b0b",
}


@lru_cache(maxsize=None)
def colour_table(colours: Colours) -> np.ndarray:
    """Return red, green, blue and alpha of each number of a picture (uint8, 256 x 4).

    What was not measured is transparent.
    """
    stops = np.array([list(bytes.fromhex(one)) for one in _STOPS[colours].split()], np.float64)
    places = np.linspace(0.0, len(stops) - 1.0, LAST_SHADE + 1)
    table = np.zeros((NOT_MEASURED + 1, 4), np.uint8)
    for channel in range(3):
        found = np.interp(places, np.arange(len(stops)), stops[:, channel])
        table[: LAST_SHADE + 1, channel] = np.rint(found)
    table[: LAST_SHADE + 1, 3] = 255
    return table


def shade_numbers(shades: np.ndarray, signed: bool) -> np.ndarray:
    """Return the number of each shade.

    Args:
        shades: 0 to 1, or -1 to 1 if signed; NaN where nothing was measured.
        signed: Whether the shades have a sign.
    """
    measured = np.isfinite(shades)
    parts = np.where(measured, shades, 0.0)
    if signed:
        parts = (parts + 1.0) / 2.0
    numbers = np.rint(np.clip(parts, 0.0, 1.0) * LAST_SHADE).astype(np.uint8)
    numbers[~measured] = NOT_MEASURED
    return numbers
