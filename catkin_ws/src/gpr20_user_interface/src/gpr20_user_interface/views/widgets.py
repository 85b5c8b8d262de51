"""Small helpers for buttons and for what the style sheet asks for."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtWidgets import QPushButton, QWidget


def new_button(act: Callable[[], None], text: str = "") -> QPushButton:
    """Return a button that does something when it is clicked."""
    button = QPushButton(text)
    connect_click(button, act)
    return button


def connect_click(button: QPushButton, act: Callable[[], None]) -> None:
    """Let a button do something when it is clicked."""
    # Not the function itself, which would get whether the button is checked.
    button.clicked.connect(lambda: act())


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
