"""The dialog over the tabs with a question: a notice that can be accepted."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QWidget

from gpr20_common.message import Message
from gpr20_operator.robot.notices import Notice
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.widgets.labels import PulledText
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import column, new_button, new_label, row, say


class NoticeView(Overlay):
    """Shows a Notice until it is closed by a touch; details only on request."""

    resume_pressed = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.notice: Optional[Notice] = None
        self._on_accepted: Optional[Callable[[], None]] = None
        self.title = new_label("title", wraps=True)
        self.reason, self.details = PulledText("reason"), PulledText("details")
        self.first_title = new_label("first_title", text=Message("Do this first"))
        self.first, self.then = new_label("first", wraps=True), new_label(wraps=True)
        self.accept_button = new_button(self._on_accept, Message("CONTINUE WITH THIS VNA"))
        self.resume = new_button(self._on_resume, Message("RESUME"))
        self.details_button = new_button(lambda: self._show_details(self.details.isHidden()))
        self.close_button = new_button(self.hide)
        # Its words are longer than those of the other buttons.
        buttons = row((self.accept_button, 2), (self.resume, 1), (self.details_button, 1))
        buttons.addWidget(self.close_button, 1)
        texts = (self.title, (self.reason, 1), (self.details, 1), self.first_title, self.first)
        self.setLayout(column(*texts, self.then, buttons, margin=2 * GAP_PX))

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
        self.accept_button.setVisible(on_accepted is not None)
        say(self.close_button, Message("NOT NOW") if on_accepted else Message("CLOSE"))
        self.details.setText("\n".join(notice.details))
        self.first_title.setVisible(notice.first is not None)
        self.resume.setVisible(notice.resumable)
        self.details_button.setVisible(bool(notice.details))
        self.title.setText(shown_text(notice.title))
        self.reason.setText(sentence_text(notice.text))
        for label, message in ((self.first, notice.first), (self.then, notice.then)):
            label.setVisible(message is not None)
            label.setText("" if message is None else shown_text(message))
        self.open()

    def _on_resume(self) -> None:
        self.hide()
        self.resume_pressed.emit()

    def _on_accept(self) -> None:
        self.hide()
        if self._on_accepted is not None:
            self._on_accepted()

    def _show_details(self, shown: bool) -> None:
        # In the place of the sentence: there is no room for both.
        self.details.setVisible(shown)
        self.reason.setVisible(not shown)
        say(self.details_button, Message("HIDE DETAILS") if shown else Message("DETAILS"))
