"""A figure with a title above and notes below, which never overlap the axes or each other."""

from __future__ import annotations

from functools import lru_cache
from typing import List, Sequence, Tuple

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font

TITLE_PT, NOTE_PT = 10.0, 7.0
POINTS_PER_IN = 72.0
LINE_SPACING = 1.25
# Letters are measured in this size; their widths have 16 binary places.
MEASURED_PT, FIXED_POINT = 100.0, 65536.0
# Texts on a screen are up to a few percent wider than in points.
PART_OF_WIDTH = 0.93


class NotedFigure(Figure):
    """A figure whose title and notes are wrapped to its width; it grows by their lines.

    Args:
        size_in: Width, and height of everything but title and notes [inches].
        title: Text above the axes.
        notes: Sentences below the axes, each from a new line.
    """

    def __init__(self, size_in: Tuple[float, float], title: str, notes: Sequence[str]) -> None:
        super().__init__(figsize=size_in, layout="compressed")
        width_in, axes_height_in = size_in
        heading = wrapped([title], width_in, TITLE_PT)
        remarks = wrapped(notes, width_in, NOTE_PT)
        # A dollar sign is no formula.
        self.suptitle("\n".join(heading), fontsize=TITLE_PT, parse_math=False)
        self.supxlabel("\n".join(remarks), fontsize=NOTE_PT, color="firebrick", parse_math=False)
        points = len(heading) * TITLE_PT + len(remarks) * NOTE_PT
        self.set_figheight(axes_height_in + points * LINE_SPACING / POINTS_PER_IN)


def wrapped(texts: Sequence[str], width_in: float, size_pt: float) -> List[str]:
    """Return texts as lines that are not wider than a figure.

    Args:
        texts: Each begins a new line.
        width_in: Width of the figure [inches].
        size_pt: Size of the letters [points].

    Returns:
        The lines. A word that is wider than the figure is divided.
    """
    widest_pt = PART_OF_WIDTH * width_in * POINTS_PER_IN
    space_pt = width_pt(" ", size_pt)
    lines: List[str] = []
    for text in (line for one in texts for line in one.splitlines()):
        line, used_pt = "", 0.0
        for word in text.split():
            for part in _divided(word, widest_pt, size_pt):
                part_pt = width_pt(part, size_pt)
                if line and used_pt + space_pt + part_pt > widest_pt:
                    lines.append(line)
                    line, used_pt = "", 0.0
                line = f"{line} {part}" if line else part
                used_pt += part_pt + (space_pt if used_pt else 0.0)
        if line:
            lines.append(line)
    return lines


def width_pt(text: str, size_pt: float) -> float:
    """Return the width of a line of text [points]."""
    return size_pt * sum(_advance(letter) for letter in text)


def _divided(word: str, widest_pt: float, size_pt: float) -> List[str]:
    parts, used_pt = [""], 0.0
    for letter in word:
        letter_pt = width_pt(letter, size_pt)
        if parts[-1] and used_pt + letter_pt > widest_pt:
            parts.append("")
            used_pt = 0.0
        parts[-1] += letter
        used_pt += letter_pt
    return parts


@lru_cache(maxsize=None)
def _advance(letter: str) -> float:
    """Return the width of a letter of the usual font, in parts of its size."""
    font = get_font(findfont(FontProperties()))
    font.set_size(MEASURED_PT, POINTS_PER_IN)
    return float(font.load_char(ord(letter)).linearHoriAdvance) / FIXED_POINT / MEASURED_PT
