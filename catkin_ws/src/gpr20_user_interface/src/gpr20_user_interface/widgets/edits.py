"""A field with its title inside: all of it takes the touch."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, Qt, pyqtSignal
from PyQt5.QtGui import QFocusEvent, QFont, QFontMetrics, QMouseEvent, QResizeEvent
from PyQt5.QtWidgets import (
    QFrame,
    QLabel,
    QLineEdit,
    QSizePolicy,
    QStyle,
    QStyleOptionFrame,
    QVBoxLayout,
)

from gpr20_user_interface.look.look import TOUCH_PX, look_of
from gpr20_user_interface.look.style_sheet import FITS
from gpr20_user_interface.widgets.widgets import set_look

# More characters than any parameter needs, an address of any form included.
MAX_LENGTH = 80
# The cursor, and what QLineEdit keeps free at both ends.
KEPT_FREE_PX = 6


class TouchEdit(QLineEdit):
    """A line that reports a tap; a keyboard can write in it as usual.

    The letters become smaller where a text is long. A text that is longer still shows its
    beginning, unless it is being written: a number without its first digits is another number.
    """

    tapped = pyqtSignal()

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setMaxLength(MAX_LENGTH)
        self.setMinimumWidth(TOUCH_PX)
        self.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
        self.textChanged.connect(lambda _text: self._fit())

    @property
    def room_px(self) -> int:
        """Width in which a text is seen completely [px]."""
        option = QStyleOptionFrame()
        self.initStyleOption(option)
        inside = self.style().subElementRect(QStyle.SubElement.SE_LineEditContents, option, self)
        return int(inside.width()) - KEPT_FREE_PX

    def setText(self, text: str) -> None:  # noqa: N802 (as in QLineEdit)
        """Replace the text; its beginning is seen."""
        super().setText(text)
        self.setCursorPosition(0)

    def select_all(self) -> None:
        """Select the text for the first key to replace; the beginning is seen."""
        self.setSelection(len(self.text()), -len(self.text()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the field."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()

    def focusOutEvent(self, event: QFocusEvent) -> None:  # noqa: N802
        """Qt: another field is written in."""
        super().focusOutEvent(event)
        self.setCursorPosition(0)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self._fit()

    def show_problem(self, problem: str) -> None:
        """Mark the field as wrong; an empty problem as right."""
        set_look(self, "wrong", bool(problem))
        self.setToolTip(problem)

    def _fit(self) -> None:
        fitting = (
            name for name, size_px in FITS.items() if self._width_px(size_px) <= self.room_px
        )
        set_look(self, "fit", next(fitting, list(FITS)[-1]))

    def _width_px(self, size_px: int) -> int:
        font = QFont(self.font())
        font.setPixelSize(look_of(self).px(size_px))
        return int(QFontMetrics(font).horizontalAdvance(self.text()))


class FieldBox(QFrame):
    """A title above an edit, in one frame."""

    tapped = pyqtSignal()

    def __init__(self, edit: TouchEdit) -> None:
        super().__init__()
        self.setObjectName("box")
        self.edit = edit
        self.title = QLabel()
        self.title.setObjectName("quiet")
        edit.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignLeft)
        edit.tapped.connect(self.tapped)
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        self._layout.addWidget(self.title)
        self._layout.addWidget(edit, 1)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        self.setMinimumHeight(look.px(TOUCH_PX))
        self._layout.setContentsMargins(look.px(8), look.px(4), look.px(8), look.px(4))

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            self.restyle()

    def set_chosen(self, chosen: bool) -> None:
        """Show whether the keys write in this field."""
        set_look(self, "chosen", chosen)

    def show_problem(self, problem: str) -> None:
        """Mark the field as wrong; an empty problem as right."""
        if self.property("wrong") is not bool(problem):
            set_look(self, "wrong", bool(problem))
            # The rules for what is inside ask for the frame.
            for child in (self.title, self.edit):
                self.style().unpolish(child)
                self.style().polish(child)
        self.edit.show_problem(problem)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the frame around the edit."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()
