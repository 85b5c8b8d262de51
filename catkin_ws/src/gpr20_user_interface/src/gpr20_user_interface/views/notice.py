"""The dialog over the tabs: what happened, what to do next, and technical details."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QTextEdit, QVBoxLayout, QWidget

from gpr20_user_interface.mid.notices import Notice
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.translation import shown_text
from gpr20_user_interface.views.widgets import new_button


class NoticeView(Overlay):
    """Shows a Notice until it is closed by a touch."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._notice: Optional[Notice] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.title.setWordWrap(True)
        self.reason = _text_area()
        self.details_title = QLabel()
        self.details_title.setObjectName("quiet")
        self.details = _text_area()
        self.details.setObjectName("details")
        self.next_step = QLabel()
        self.next_step.setWordWrap(True)
        self.close_button = new_button(self.hide)
        self.buttons = QHBoxLayout()
        self.buttons.addWidget(self.close_button, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(24, 12, 24, 12)
        layout.setSpacing(8)
        layout.addWidget(self.title)
        layout.addWidget(self.reason, 3)
        layout.addWidget(self.next_step)
        layout.addWidget(self.details_title)
        layout.addWidget(self.details, 2)
        layout.addLayout(self.buttons)

    def show_notice(self, notice: Notice) -> None:
        """Open with the texts of a notice."""
        self._notice = notice
        self.retranslate()
        self.open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("CLOSE"))
        self.details_title.setText(self.tr("Details"))
        notice = self._notice
        if notice is None:
            return
        self.title.setText(shown_text(notice.title))
        self.reason.setPlainText(shown_text(notice.text))
        self.next_step.setVisible(notice.next_step is not None)
        self.next_step.setText("" if notice.next_step is None else shown_text(notice.next_step))
        self.details_title.setVisible(bool(notice.details))
        self.details.setVisible(bool(notice.details))
        self.details.setPlainText("\n".join(notice.details))


def _text_area() -> QTextEdit:
    area = QTextEdit()
    area.setReadOnly(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return area
