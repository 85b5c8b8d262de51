"""How the window looks: its theme, its signs, and its sizes for the screen that it is on."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from PyQt5.QtCore import QByteArray, QRectF, Qt
from PyQt5.QtGui import QIcon, QPainter, QPixmap, QPixmapCache
from PyQt5.QtSvg import QSvgRenderer
from PyQt5.QtWidgets import QWidget

from gpr20_operator.palette import LEVEL_COLOURS, ColourPair, Mark, TextColours, Theme

__all__ = ["LEVEL_COLOURS", "ColourPair", "Look", "Mark", "TextColours", "Theme", "look_of"]

TEMPLATE = Path(__file__).with_name("style.qss")
# Every size is written for this screen, and scaled for another one.
DESIGN_WIDTH_PX = 800
DESIGN_HEIGHT_PX = 480
# A screen of 480x320, less the frame of a window.
SMALLEST_SCALE = 0.57
LARGEST_SCALE = 1.8
# Below it a gloved finger does not hit one button alone: the window can only be looked at.
TOUCHABLE_SCALE = 0.8

# What a gloved finger hits: 60 pixels are 11 mm on a 7 inch screen of 800x480.
TOUCH_PX = 60
# All other sizes are multiples of half of it.
GAP_PX = 8
TEXT_PX = 18
BORDER_PX = 2
TOP_BAR_PX = 76


@dataclass(frozen=True)
class Look:
    """A theme and a scale.

    Attributes:
        theme: The colours.
        scale: Size of everything; 1.0 on a screen of 800x480.
    """

    theme: Theme = Theme.SUN
    scale: float = 1.0

    @property
    def touchable(self) -> bool:
        """Whether the robot may be operated on a screen of this size."""
        return self.scale >= TOUCHABLE_SCALE

    def px(self, design_px: float) -> int:
        """Return a size of the design on this screen; at least one pixel."""
        return max(1, round(design_px * self.scale))

    def text(self, colours: TextColours) -> ColourPair:
        """Return a text's colours."""
        return colours.of(self.theme)

    def colour(self, mark: Mark) -> str:
        """Return the colour of a line or mark."""
        return mark.of(self.theme)


def scale_for(width_px: int, height_px: int) -> float:
    """Return the scale at which the design fills a screen."""
    scale = min(width_px / DESIGN_WIDTH_PX, height_px / DESIGN_HEIGHT_PX)
    return min(max(scale, SMALLEST_SCALE), LARGEST_SCALE)


def look_of(widget: QWidget) -> Look:
    """Return the look of the window that a widget is in; the default before it is in one."""
    found = getattr(widget.window(), "look", None)
    return found if isinstance(found, Look) else Look()


def style_sheet(look: Look) -> str:
    """Return the style sheet of a theme at a scale."""
    rules = [TEMPLATE.read_text(encoding="utf-8")]
    for level, colours in LEVEL_COLOURS.items():
        job = f'[job="{level.value}"]'
        rules.append(f"QFrame#band{job}, QLabel{job} {{ @{colours.name} }}")

    def pair(found: re.Match[str]) -> str:
        ink, ground = look.text(TextColours[found[1]])
        return f"color: {ink}; background: {ground};"

    text = re.sub(r"@([A-Z_]+)", pair, "\n".join(rules))
    text = re.sub(r"\$([A-Z_]+)", lambda found: look.colour(Mark[found[1]]), text)
    return re.sub(r"\b([0-9]+)px", lambda found: f"{look.px(int(found[1]))}px", text)


FOLDER = Path(__file__).with_name("icons")


def icon(name: str, colour: str, size_px: int) -> QIcon:
    """Return a sign for a button; it keeps its colour where the button is disabled.

    Args:
        name: Of a file in `look/icons`, without its ending.
        colour: As "#1f4e8c", from the palette.
        size_px: Of both sides.

    Raises:
        FileNotFoundError: There is no such sign.
    """
    shown = QIcon()
    for mode in (QIcon.Mode.Normal, QIcon.Mode.Disabled, QIcon.Mode.Selected, QIcon.Mode.Active):
        shown.addPixmap(sign(name, colour, size_px), mode)
    return shown


def sign(name: str, colour: str, size_px: int) -> QPixmap:
    """Return a sign to paint; arguments as those of `icon`."""
    key = f"{name} {colour} {size_px}"
    known = QPixmapCache.find(key)
    if known is not None:
        return known
    drawing = (FOLDER / f"{name}.svg").read_text(encoding="utf-8").replace("currentColor", colour)
    picture = QPixmap(size_px, size_px)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    QSvgRenderer(QByteArray(drawing.encode())).render(painter, QRectF(picture.rect()))
    painter.end()
    QPixmapCache.insert(key, picture)
    return picture
