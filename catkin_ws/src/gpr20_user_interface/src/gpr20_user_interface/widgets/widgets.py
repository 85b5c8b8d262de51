"""Pages and sheets, small widgets, and layouts and texts that follow scale and language."""

from __future__ import annotations

from typing import Callable, Optional, Sequence, TypeVar, Union

from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtGui import QHideEvent, QShowEvent
from PyQt5.QtWidgets import (
    QApplication,
    QBoxLayout,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QPushButton,
    QTextEdit,
    QVBoxLayout,
    QWidget,
)

from gpr20_common.message import Message
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import (
    GAP_PX,
    TOP_BAR_PX,
    Look,
    TextColours,
    look_of,
    sign,
)
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.touch.guard import note_touch_change

AnyLayout = TypeVar("AnyLayout", bound=QLayout)
# Property of a layout: its margins beside and above, and its gap, in pixels of the design.
DESIGN = "design"
SIGN_PX = 64  # of an empty state
# Property of a widget: the Message that is its text.
TEXT = "message"


def spaced(
    layout: AnyLayout, margin: int = 0, gap: int = GAP_PX, edge: Optional[int] = None
) -> AnyLayout:
    """Return a layout whose margins and gap [pixels of the design] the window scales.

    Args:
        layout: The layout.
        margin: On each side.
        gap: Between its parts.
        edge: Above and below; None: as beside.
    """
    layout.setProperty(DESIGN, [margin, margin if edge is None else edge, gap])
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
    margin, edge, gap = (look.px(one) if one else 0 for one in layout.property(DESIGN))
    layout.setContentsMargins(margin, edge, margin, edge)
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


class PulledText(QTextEdit):
    """A text of several lines that a finger pulls up where there is no room for all of it."""

    def __init__(self, name: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        self.setReadOnly(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def text(self) -> str:
        """Return the text."""
        return str(self.toPlainText())

    def setText(self, text: str) -> None:  # noqa: N802 (as QLabel names it)
        """Show a text from its beginning; the same one stays where it was pulled."""
        if text != self.text():
            self.setPlainText(text)


class EmptyState(QWidget):
    """A sign, one sentence and at most one button; its page writes the texts.

    Attributes:
        sentence: What is missing.
        button: What to do.
    """

    def __init__(self) -> None:
        super().__init__()
        self._sign, self.sentence = QLabel(), new_label(wraps=True)
        self._act: Callable[[], None] = lambda: None
        self.button = new_button(lambda: self._act())
        for label in (self._sign, self.sentence):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        button = row(self.button)
        button.setAlignment(self.button, Qt.AlignmentFlag.AlignHCenter)
        layout = column(self._sign, self.sentence, button, gap=2 * GAP_PX)
        layout.insertStretch(0)
        layout.addStretch()
        self.setLayout(layout)

    def explain(
        self, name: str, sentence: str, button: str = "", act: Optional[Callable[[], None]] = None
    ) -> None:
        """Show what is missing.

        Args:
            name: Of the sign, as `icon` knows it.
            sentence: What is missing.
            button: What to do; empty: there is no button.
            act: Does it.
        """
        look = look_of(self)
        self._sign.setPixmap(sign(name, look.text(TextColours.QUIET).ink, look.px(SIGN_PX)))
        self.sentence.setText(sentence)
        self.button.setText(button)
        self.button.setVisible(act is not None)
        self._act = act or self._act


class Page:
    """Follows events and what is known; the pages of the window override what they need."""

    def on_event(self, event: object) -> None:
        """Take an event."""

    def show_state(self, snapshot: Snapshot) -> None:
        """Show what is known now; 5 times a second, and after each request."""

    def show_again(self) -> None:
        """Show the same in another language, theme or size, where it was not written by `say`."""


class Overlay(QFrame):
    """Covers its window below the top bar while it is open; closed at first.

    A dialog of its own could cover STOP, or be lost behind the window. For a moment after it has
    opened or closed, the window takes no touch but that of STOP.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("sheet")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()

    def open(self) -> None:
        """Cover the tabs."""
        self.cover()
        self.show()
        self.raise_()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        """Qt: it opens."""
        super().showEvent(event)
        note_touch_change(self)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        """Qt: it closes."""
        super().hideEvent(event)
        note_touch_change(self)

    def cover(self) -> None:
        """Lie below the top bar, also after the window has another size."""
        window = self.parentWidget()
        top_px = look_of(self).px(TOP_BAR_PX)
        self.setGeometry(0, top_px, window.width(), window.height() - top_px)
