"""The dialog over the tabs with a question: a notice that can be accepted."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QTextEdit, QVBoxLayout, QWidget

from gpr20_operator.robot.notices import Notice
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button


class NoticeView(Overlay):
    """Shows a Notice until it is closed by a touch; details only on request."""

    resume_pressed = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.notice: Optional[Notice] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.title.setWordWrap(True)
        self.reason = _text_area()
        self.reason.setObjectName("reason")
        self.details = _text_area()
        self.details.setObjectName("details")
        self.first_title = QLabel()
        self.first_title.setObjectName("first_title")
        self.first = QLabel()
        self.first.setObjectName("first")
        self.first.setWordWrap(True)
        self.then = QLabel()
        self.then.setWordWrap(True)
        self.accept_button = new_button(self._on_accept)
        self.resume = new_button(self._on_resume)
        self.details_button = new_button(self._on_details)
        self.close_button = new_button(self.hide)
        self._on_accepted: Optional[Callable[[], None]] = None
        self.buttons = QHBoxLayout()
        # Its words are longer than those of the other buttons.
        self.buttons.addWidget(self.accept_button, 2)
        for button in (self.resume, self.details_button, self.close_button):
            self.buttons.addWidget(button, 1)
        self._layout = QVBoxLayout(self)
        self._layout.addWidget(self.title)
        self._layout.addWidget(self.reason, 1)
        self._layout.addWidget(self.details, 1)
        for widget in (self.first_title, self.first, self.then):
            self._layout.addWidget(widget)
        self._layout.addLayout(self.buttons)
        self.details.hide()

    def show_notice(self, notice: Notice) -> None:
        """Open with the texts of a notice."""
        self.ask(notice, None)

    def ask(self, notice: Notice, on_accepted: Optional[Callable[[], None]]) -> None:
        """Open with a question; closing it is a no.

        Args:
            notice: What is asked.
            on_accepted: Called if the operator accepts; None: nothing is asked.
        """
        self.notice, self._on_accepted = notice, on_accepted
        self._show_details(False)
        self.retranslate()
        self.open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        asked = self._on_accepted is not None
        self.accept_button.setText(self.tr("CONTINUE WITH THIS VNA"))
        self.accept_button.setVisible(asked)
        self.close_button.setText(self.tr("NOT NOW") if asked else self.tr("CLOSE"))
        self.resume.setText(self.tr("RESUME"))
        self._name_details_button()
        self.first_title.setText(self.tr("Do this first"))
        notice = self.notice
        if notice is None:
            return
        self.title.setText(shown_text(notice.title))
        self.reason.setPlainText(sentence_text(notice.text))
        self.details.setPlainText("\n".join(notice.details))
        self.first_title.setVisible(notice.first is not None)
        for label, message in ((self.first, notice.first), (self.then, notice.then)):
            label.setVisible(message is not None)
            label.setText("" if message is None else shown_text(message))
        self.resume.setVisible(notice.resumable)
        self.details_button.setVisible(bool(notice.details))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(2 * gap_px, gap_px, 2 * gap_px, gap_px)
        self._layout.setSpacing(gap_px // 2)
        self.buttons.setSpacing(gap_px)

    def _on_resume(self) -> None:
        self.hide()
        self.resume_pressed.emit()

    def _on_accept(self) -> None:
        self.hide()
        if self._on_accepted is not None:
            self._on_accepted()

    def _on_details(self) -> None:
        self._show_details(self.details.isHidden())

    def _show_details(self, shown: bool) -> None:
        # In the place of the sentence: there is no room for both.
        self.details.setVisible(shown)
        self.reason.setVisible(not shown)
        self._name_details_button()

    def _name_details_button(self) -> None:
        hidden = self.details.isHidden()
        self.details_button.setText(self.tr("DETAILS") if hidden else self.tr("HIDE DETAILS"))


def _text_area() -> QTextEdit:
    area = QTextEdit()
    area.setReadOnly(True)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return area
