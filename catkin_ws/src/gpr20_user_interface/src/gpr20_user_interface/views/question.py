"""The dialog over the tabs with a question: a notice that can be accepted."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.mid.notices import Notice
from gpr20_user_interface.views.notice import NoticeView
from gpr20_user_interface.views.widgets import new_button


class AnalyzerQuestion(NoticeView):
    """Asks whether a survey is continued with another analyzer; closing it is a no."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._on_accepted: Callable[[], None] = self.hide
        self.accept_button = new_button(self._accept)
        # Its words are longer than those of the other buttons.
        self.buttons.insertWidget(0, self.accept_button, 2)

    def ask(self, notice: Notice, on_accepted: Callable[[], None]) -> None:
        """Open with the texts of a notice.

        Args:
            notice: What is asked.
            on_accepted: Called if the operator accepts.
        """
        self._on_accepted = on_accepted
        self.show_notice(notice)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        super().retranslate()
        self.accept_button.setText(self.tr("CONTINUE WITH THIS VNA"))
        self.close_button.setText(self.tr("NOT NOW"))

    def _accept(self) -> None:
        self.hide()
        self._on_accepted()
