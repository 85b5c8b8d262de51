"""Cards, questions and the warning of a STOP: what the operator must see, on every page."""

from __future__ import annotations

import math
from typing import Callable, Optional

from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QWidget

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.events import Answer
from gpr20_operator.robot.notices import (
    ANSWER_S,
    MOTORS_OFF,
    CardWatch,
    Notice,
    Refused,
    StopConfirmation,
    band_notice,
    refusal_notice,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.bars import TopBar
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    Page,
    PulledText,
    column,
    new_button,
    new_label,
    row,
    say,
)


class NoticeView(Overlay):
    """Shows a Notice until it is closed by a touch; details only on request."""

    resume_pressed = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.notice: Optional[Notice] = None
        self.title = new_label("title", wraps=True)
        self.reason, self.details = PulledText("reason"), PulledText("details")
        self.first_title = new_label("first_title", text=Message("Do this first"))
        self.first, self.then = new_label("first", wraps=True), new_label(wraps=True)
        self.resume = new_button(self._on_resume, Message("RESUME"))
        self.details_button = new_button(lambda: self._show_details(self.details.isHidden()))
        self.close_button = new_button(self.hide, Message("CLOSE"))
        buttons = row((self.resume, 1), (self.details_button, 1), (self.close_button, 1))
        texts = (self.title, (self.reason, 1), (self.details, 1), self.first_title, self.first)
        self.setLayout(column(*texts, self.then, buttons, margin=2 * GAP_PX))

    def show_notice(self, notice: Notice) -> None:
        """Open with a notice."""
        self.notice = notice
        self._show_details(False)
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

    def _show_details(self, shown: bool) -> None:
        # In the place of the sentence: there is no room for both.
        self.details.setVisible(shown)
        self.reason.setVisible(not shown)
        say(self.details_button, Message("HIDE DETAILS") if shown else Message("DETAILS"))


class StopWarningView(Overlay):
    """Stays until the stop is confirmed, or the operator closes it by a hold."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("stop_warning")
        self.title = new_label("motors_off", wraps=True, text=MOTORS_OFF)
        self.title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.text = new_label(wraps=True)
        self.close_button = HoldButton()
        say(self.close_button, Message("Hold to close"))
        parts = ((self.title, 3), (self.text, 1), self.close_button)
        self.setLayout(column(*parts, margin=3 * GAP_PX))

    def show_warning(self, warning: Optional[Message]) -> None:
        """Show a warning over everything; None: there is none."""
        if warning is None:
            self.hide()
            return
        say(self.text, warning)
        if not self.isVisible():
            self.open()
        # Another sheet may have opened since.
        self.raise_()


class Alerts(Page):
    """Passes PAUSE, RESUME and STOP on; opens the card of each fault and of each refusal.

    Attributes:
        notice: The card.
        stop_warning: What is shown until a STOP is confirmed.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        top_bar: TopBar,
        ask_resume: Callable[[], None],
        ask_resume_with: Callable[[str, Message], None],
        clock: Clock,
    ) -> None:
        self._survey = survey
        self._ask_resume_with = ask_resume_with
        self._cards = CardWatch()
        # The card that was opened without a touch, until it is closed.
        self._opened: Optional[Notice] = None
        self._stop = StopConfirmation(clock)
        self.notice = NoticeView(window)
        self.stop_warning = StopWarningView(window)
        self._answer_due = QTimer(window)
        self._answer_due.setSingleShot(True)
        self._answer_due.setTimerType(Qt.TimerType.PreciseTimer)
        self._answer_due.setInterval(math.ceil(ANSWER_S * 1000.0) + 1)
        self._answer_due.timeout.connect(self._show_stop)
        top_bar.stop.pressed.connect(self._on_stop)
        top_bar.pause_pressed.connect(survey.pause)
        top_bar.resume_pressed.connect(ask_resume)
        top_bar.band.touched.connect(self.show_condition)
        self.notice.resume_pressed.connect(top_bar.resume_pressed)
        self.stop_warning.close_button.held.connect(self._on_stop_warning_closed)

    def on_event(self, event: object) -> None:
        """Follow what is known of a STOP."""
        self._stop.on_event(event)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        card = self._cards.note(snapshot)
        if card is not None:
            self._open(card)
        elif self._cards.is_over and self._opened is not None:
            if self.notice.notice is self._opened:
                self.notice.hide()
            self._opened = None
        self._show_stop()

    def show_condition(self) -> None:
        """Show all that the band says, and what to do first."""
        snapshot = self._survey.snapshot
        if not snapshot.replay:
            self.notice.show_notice(band_notice(snapshot))

    def take_refusal(self, refusal: Optional[Answer]) -> None:
        """Show why a request was refused; None: none was."""
        if refusal is None:
            return
        if not refusal.other_analyzer:
            self.show_refusal(Refused[refusal.request.name], refusal.message)
            return
        # The status of the survey opens a card with the same reason.
        self._cards.note(self._survey.state())
        self.notice.hide()
        self._ask_resume_with(refusal.other_analyzer, refusal.message)

    def show_refusal(self, refused: Refused, reason: Message) -> None:
        """Show why something did not succeed."""
        self.notice.show_notice(refusal_notice(refused, reason))

    def _open(self, card: Notice) -> None:
        """Open the card of a fault, unless a card says it already."""
        shown = self.notice.notice if self.notice.isVisible() else None
        said = shown is not None and (shown.text, shown.first) == (card.text, card.first)
        if not said:
            self._opened = card
            self.notice.show_notice(card)

    def _on_stop(self) -> None:
        # First: nothing that is shown may delay it.
        self._survey.stop()
        self._stop.press()
        # Not with the next refresh, which may come later.
        self._answer_due.start()

    def _show_stop(self) -> None:
        self.stop_warning.show_warning(self._stop.warning(self._survey.snapshot))
        outcome, self._stop.outcome = self._stop.outcome, None
        if outcome is not None:
            self.notice.show_notice(outcome)

    def _on_stop_warning_closed(self) -> None:
        self._stop.close()
        self.stop_warning.show_warning(None)
