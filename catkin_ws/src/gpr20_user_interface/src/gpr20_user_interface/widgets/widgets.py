"""Small widgets, and layouts and texts that follow scale and language of the window."""

from __future__ import annotations

from typing import Callable, Optional, Sequence, TypeVar, Union

from PyQt5.QtCore import QEvent
from PyQt5.QtWidgets import (
    QApplication,
    QBoxLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gpr20_common.message import Message
from gpr20_user_interface.look.look import GAP_PX, Look
from gpr20_user_interface.look.translation import shown_text

AnyLayout = TypeVar("AnyLayout", bound=QLayout)
# Property of a layout: its margin and its gap in pixels of the design.
DESIGN = "design"
# Property of a widget: the Message that is its text.
TEXT = "message"


def spaced(layout: AnyLayout, margin: int = 0, gap: int = GAP_PX) -> AnyLayout:
    """Return a layout whose margin and gap [pixels of the design] the window scales."""
    layout.setProperty(DESIGN, [margin, gap])
    _fit(layout, Look())
    return layout


def row(*parts: object, margin: int = 0, gap: int = GAP_PX) -> QHBoxLayout:
    """Return widgets and layouts beside each other; a pair is one of them and its stretch."""
    return _filled(QHBoxLayout(), parts, margin, gap)


def column(*parts: object, margin: int = 0, gap: int = GAP_PX) -> QVBoxLayout:
    """Return widgets and layouts below each other; a pair is one of them and its stretch."""
    return _filled(QVBoxLayout(), parts, margin, gap)


def _filled(layout: AnyLayout, parts: Sequence[object], margin: int, gap: int) -> AnyLayout:
    assert isinstance(layout, QBoxLayout)
    for part in parts:
        what, stretch = part if isinstance(part, tuple) else (part, 0)
        if isinstance(what, QLayout):
            layout.addLayout(what, stretch)
        else:
            layout.addWidget(what, stretch)
    return spaced(layout, margin, gap)


def holding(layout: QLayout, name: str = "") -> QWidget:
    """Return a widget with a layout, and its name in the style sheet."""
    widget = QWidget()
    widget.setObjectName(name)
    widget.setLayout(layout)
    return widget


def grid(margin: int = 0, gap: int = GAP_PX) -> QGridLayout:
    """Return an empty grid."""
    return spaced(QGridLayout(), margin, gap)


def tiled(widgets: Sequence[QWidget], columns: int) -> QGridLayout:
    """Return a grid of cells of one size, filled row by row."""
    layout = grid()
    for number, widget in enumerate(widgets):
        place = divmod(number, columns)
        layout.addWidget(widget, *place)
        layout.setRowStretch(place[0], 1)
        layout.setColumnStretch(place[1], 1)
    return layout


def fit_layouts(window: QWidget, look: Look) -> None:
    """Scale the layouts of a window."""
    for layout in window.findChildren(QLayout):
        if isinstance(layout, QLayout) and layout.property(DESIGN):
            _fit(layout, look)


def _fit(layout: QLayout, look: Look) -> None:
    margin, gap = (look.px(one) if one else 0 for one in layout.property(DESIGN))
    layout.setContentsMargins(margin, margin, margin, margin)
    if isinstance(layout, QGridLayout):
        layout.setHorizontalSpacing(gap)
        layout.setVerticalSpacing(gap)
    else:
        layout.setSpacing(gap)


def say(widget: QWidget, message: Message) -> None:
    """Set the text of a label or button, which follows the language of the window."""
    widget.setProperty(TEXT, message)
    widget.setText(shown_text(message))


def offer(button: QPushButton, text: Message, obstacle: Optional[Message] = None) -> None:
    """Let a button be touched; else it says why it cannot."""
    button.setEnabled(obstacle is None)
    say(button, obstacle or text)


def say_again(window: QWidget) -> None:
    """Write the texts of a window in the language of the application."""
    for widget in window.findChildren(QWidget):
        if isinstance(widget, QWidget) and widget.property(TEXT) is not None:
            say(widget, widget.property(TEXT))


def new_label(name: str = "", wraps: bool = False, text: Optional[Message] = None) -> QLabel:
    """Return a label with its name in the style sheet."""
    label = QLabel()
    label.setObjectName(name)
    label.setWordWrap(wraps)
    if text is not None:
        say(label, text)
    return label


def new_button(act: Callable[[], None], text: Union[str, Message] = "") -> QPushButton:
    """Return a button that does something when it is clicked."""
    button = QPushButton()
    if isinstance(text, Message):
        say(button, text)
    else:
        button.setText(text)
    # Not the function itself, which would get whether the button is checked.
    button.clicked.connect(lambda: act())
    return button


def set_look(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet asks for; it looks at them only when it is applied."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
        # The padding of a label, too, may be another one.
        QApplication.sendEvent(widget, QEvent(QEvent.Type.StyleChange))
