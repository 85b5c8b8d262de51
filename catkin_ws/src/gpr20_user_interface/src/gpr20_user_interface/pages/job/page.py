"""The survey that runs: how far it is, what it does, and what to do, in large type."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout

from gpr20_operator.ground.traces import SurveyDescribed, TracePresenter
from gpr20_operator.robot.condition import condition_of, left_of
from gpr20_operator.robot.snapshot import Snapshot, area_of, line_of, percent_of, survey_name
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.widgets.ground_picture import GroundPicture
from gpr20_user_interface.widgets.labels import ElidedLabel, PulledText
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import fill, new_button, space

UNKNOWN = "—"


class JobPage(TranslatedWidget, Page):
    """Percentage, time that is left, line, a small map; what is wrong, and what to do first."""

    notes_pressed = pyqtSignal()
    # The operator wants to see all that is known of the condition.
    card_pressed = pyqtSignal()

    def __init__(self, traces: TracePresenter) -> None:
        super().__init__()
        self._traces = traces
        self._snapshot: Optional[Snapshot] = None
        # The survey that was described last, and its name.
        self._named = ("", "")
        self._drawn: object = None
        self.percent, self.left, self.line = QLabel(), QLabel(), QLabel()
        self.percent.setObjectName("percent")
        self.left.setObjectName("job_title")
        self.line.setObjectName("figure")
        self.area, self.message = ElidedLabel(), PulledText()
        self.remedy = QLabel()
        self.remedy.setObjectName("first")
        self.remedy.setWordWrap(True)
        self.map = GroundPicture(interactive=False)
        self.notes = new_button(self.notes_pressed.emit)
        self.card = new_button(self.card_pressed.emit)
        self._lay_out()
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.notes.setText(self.tr("NOTES"))
        self.card.setText(self.tr("DETAILS"))
        if self._snapshot is not None:
            self.refresh(self._snapshot)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        space(self, self._grid, self._buttons)

    def on_event(self, event: object) -> None:
        """Follow the name of the survey."""
        if isinstance(event, SurveyDescribed):
            self._named = survey_name(event.text)
            if self._snapshot is not None:
                self.refresh(self._snapshot)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._snapshot = snapshot
        condition, percent = condition_of(snapshot), percent_of(snapshot)
        self.percent.setText(UNKNOWN if percent is None else f"{percent} %")
        for label, text in ((self.left, left_of(snapshot)), (self.line, line_of(snapshot))):
            label.setText("" if text is None else sentence_text(text))
            label.setVisible(text is not None)
        # Not the name of the survey before this one, until it is described.
        survey_id, name = self._named
        known = snapshot.state is not None and snapshot.state.survey_id == survey_id
        parameters = snapshot.job_parameters
        area = "" if parameters is None else shown_text(area_of(parameters))
        self.area.show_text(", ".join(text for text in (name if known else "", area) if text))
        replayed = snapshot.state if snapshot.replay is not None else None
        # Beside a replay, the band says which survey it is.
        message = condition.message if replayed is None else replayed.reason
        self.message.setText(sentence_text(message))
        asks = condition.asked is not None
        self.remedy.setText("" if condition.remedy is None else shown_text(condition.remedy))
        self.remedy.setVisible(asks)
        self.card.setVisible(asks)
        self.notes.setVisible(snapshot.running and snapshot.replay is None)

    def draw(self) -> None:
        """Draw the small map, if it is seen and something has changed."""
        model = self._traces.running.map
        state = model, model.revision, model.current
        if self.isVisible():
            self.map.set_carriage(self._traces.carriage_mm)
            if state != self._drawn:
                self._drawn = state
                self.map.show_coverage(model)

    def _lay_out(self) -> None:
        self.percent.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignLeft)
        words = QVBoxLayout()
        words.setSpacing(0)
        fill(words, self.percent, self.left, self.line, self.area, (self.message, 1), self.remedy)
        self._buttons = QHBoxLayout()
        fill(self._buttons, (self.card, 1), (self.notes, 1))
        self._grid = QGridLayout(self)
        self._grid.addLayout(words, 0, 0)
        self._grid.addWidget(self.map, 0, 1, 2, 1)
        self._grid.addLayout(self._buttons, 1, 0)
        self._grid.setColumnStretch(0, 3)
        self._grid.setColumnStretch(1, 2)
        self._grid.setRowStretch(0, 1)
