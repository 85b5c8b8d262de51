"""A large button with a title and lines of text."""

from __future__ import annotations

from typing import List

from PyQt5.QtCore import QEvent, QSize, Qt
from PyQt5.QtWidgets import QPushButton, QSizePolicy, QVBoxLayout

from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.lines_label import LinesLabel
from gpr20_user_interface.views.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.views.widgets import set_look


class PlanTile(QPushButton):
    """Shows values, or what is wrong with them; a touch opens their sheet.

    Args:
        name: Which rules of the style sheet apply.
        lines: How many lines there are below the title.
    """

    def __init__(self, name: str = "tile", lines: int = 3) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._level = ""
        self.title = ElidedLabel()
        self.title.setObjectName("tile_title")
        self.lines: List[ElidedLabel] = [ElidedLabel() for _ in range(lines)]
        self.problem = LinesLabel()
        self.problem.hide()
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        self._layout.addWidget(self.title)
        for line in self.lines:
            self._layout.addWidget(line)
        self._layout.addWidget(self.problem, 1)
        for label in (self.title, *self.lines, self.problem):
            # The touch is for the button.
            label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.pressed.connect(self._show_level)
        self.released.connect(self._show_level)

    def sizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        size_px = look_of(self).px(TOUCH_PX)
        return QSize(size_px, size_px)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        return self.sizeHint()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(gap_px, gap_px // 2, gap_px, gap_px // 2)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            self.restyle()
        elif event.type() == QEvent.Type.EnabledChange:
            self._show_level()

    def show_lines(self, title: str, *lines: str) -> None:
        """Show a title and lines."""
        self.title.show_text(title)
        for label, text in zip(self.lines, (*lines, *("",) * len(self.lines))):
            label.show_text(text)

    def show_problem(self, problem: str) -> None:
        """Show what is wrong instead of the lines, marked; an empty problem: nothing is."""
        self.show_reason(problem)
        self.show_level("wrong" if problem else "")

    def show_reason(self, reason: str) -> None:
        """Show a sentence instead of the lines; an empty reason: the lines."""
        self.setToolTip(reason)
        self.problem.show_text(reason)
        for line in self.lines:
            line.setVisible(not reason)
        self.problem.setVisible(bool(reason))

    def show_level(self, level: str) -> None:
        """Show how good the values are: "wrong", "doubtful", or empty."""
        self._level = level
        self._show_level()

    def _show_level(self) -> None:
        level = self._level
        if not self.isEnabled():
            level = "locked"
        elif self.isDown():
            level = "pressed"
        if self.property("level") != level:
            set_look(self, "level", level)
            # Their colours depend on the property of the tile.
            for label in (self.title, *self.lines, self.problem):
                self.style().unpolish(label)
                self.style().polish(label)
