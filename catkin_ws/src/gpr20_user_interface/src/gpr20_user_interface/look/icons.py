"""The project's own signs, in the colour of the text beside them."""

from __future__ import annotations

from pathlib import Path

from PyQt5.QtCore import QByteArray, QRectF, Qt
from PyQt5.QtGui import QIcon, QPainter, QPixmap, QPixmapCache
from PyQt5.QtSvg import QSvgRenderer

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
