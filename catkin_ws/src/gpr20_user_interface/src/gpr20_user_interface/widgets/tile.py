"""A large button that shows values, or what is wrong with them."""

from __future__ import annotations

from typing import List, Optional

from PyQt5.QtCore import QEvent, QSize, Qt
from PyQt5.QtWidgets import QPushButton, QSizePolicy, QVBoxLayout, QWidget

from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import set_look

# Above and below: so much is left for four lines of a sentence.
EDGE_PX = 2


class TileButton(QPushButton):
    """A title, and below it lines or one sentence, and a picture; a touch opens their sheet."""

    def __init__(
        self, name: str = "tile", lines: int = 2, picture: Optional[QWidget] = None
    ) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._level = ""
        self.title = ElidedLabel()
        self.title.setObjectName("tile_title")
        self.lines: List[ElidedLabel] = [ElidedLabel() for _ in range(lines)]
        self.sentence = LinesLabel()
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        for label in (self.title, *self.lines):
            self._layout.addWidget(label)
        self._layout.addWidget(self.sentence, 1)
        if picture is not None:
            self._layout.addWidget(picture, 4)
        self._labels = (self.title, *self.lines, self.sentence)
        for label in self._labels:
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

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            look = look_of(self)
            gap_px, edge_px = look.px(GAP_PX), look.px(EDGE_PX)
            self._layout.setContentsMargins(gap_px, edge_px, gap_px, edge_px)
        elif event.type() == QEvent.Type.EnabledChange:
            self._show_level()

    def show_texts(self, title: str, *lines: str, sentence: str = "", level: str = "") -> None:
        """Show a title and what is below it.

        Args:
            title: The title.
            lines: Lines below it.
            sentence: What is shown instead of the lines; empty: the lines. One that says what is
                wrong takes the place of the title too.
            level: How good the values are: "wrong", "doubtful", or empty.
        """
        self.title.setText(title)
        self.title.setVisible(bool(title) and not (sentence and level == "wrong"))
        for label, text in zip(self.lines, (*lines, *("",) * len(self.lines))):
            label.setText(text)
            label.setVisible(not sentence)
        self.sentence.setText(sentence)
        self.sentence.setVisible(bool(sentence))
        self.setToolTip(sentence)
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
            for label in self._labels:
                self.style().unpolish(label)
                self.style().polish(label)
