"""Small widgets and what pages do with buttons."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import (
    QBoxLayout,
    QFrame,
    QLayout,
    QPushButton,
    QScrollArea,
    QWidget,
)

from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.touch.scrolling import scroll_by_finger


def fill(layout: QBoxLayout, *parts: object) -> None:
    """Add widgets and layouts in their order; a pair is one of them and its stretch."""
    for part in parts:
        what, stretch = part if isinstance(part, tuple) else (part, 0)
        if isinstance(what, QLayout):
            layout.addLayout(what, stretch)
        else:
            layout.addWidget(what, stretch)


def space(widget: QWidget, outer: QLayout, *inner: QLayout) -> None:
    """Set the gap of the look around the outermost layout, and between the parts of all."""
    gap_px = look_of(widget).px(GAP_PX)
    outer.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
    for layout in (outer, *inner):
        layout.setSpacing(gap_px)


def new_button(act: Callable[[], None], text: str = "") -> QPushButton:
    """Return a button that does something when it is clicked."""
    button = QPushButton(text)
    # Not the function itself, which would get whether the button is checked.
    button.clicked.connect(lambda: act())
    return button


def scroll_area(content: QWidget) -> QScrollArea:
    """Return an area that a finger pulls where its content is higher."""
    area = QScrollArea()
    area.setWidget(content)
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scroll_by_finger(area)
    return area


def set_look(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet asks for; it looks at them only when it is applied."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)


def in_two_lines(text: str, button: QPushButton, room_px: int) -> str:
    """Return a text with a line break where it is wider than its button.

    Args:
        text: One line.
        button: Its font is used.
        room_px: Width inside the button [px].
    """
    if button.fontMetrics().horizontalAdvance(text) <= room_px:
        return text
    spaces = [place for place, character in enumerate(text) if character == " "]
    if not spaces:
        return text
    middle = min(spaces, key=lambda place: abs(2 * place - len(text)))
    return text[:middle] + "\n" + text[middle + 1 :]
