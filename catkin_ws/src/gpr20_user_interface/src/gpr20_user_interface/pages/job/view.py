"""The job screen: how the survey is going, in large type, until the next one is planned."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout

from gpr20_operator.ground.additions import NoAdditions
from gpr20_operator.ground.map_model import MapModel
from gpr20_operator.robot.job import area_of, job_of
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.pages.ground.map_canvas import MapCanvas
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.state_band import StateBand, StateSign
from gpr20_user_interface.widgets.widgets import new_button

BAND_PX = 72
UNKNOWN = "—"


class JobView(TranslatedWidget):
    """State, percentage, time that is left, a small map, and what can be done at the end."""

    plan_pressed = pyqtSignal()
    notes_pressed = pyqtSignal()
    # The operator wants to see the fault again.
    fault_pressed = pyqtSignal()

    def __init__(self, model: MapModel) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
        self._name = ""
        self._drawn: object = None
        self.band = StateBand()
        self.sign = StateSign()
        self.title = QLabel()
        self.title.setObjectName("job_title")
        self.left = QLabel()
        self.left.setObjectName("job_title")
        self.percent = QLabel(UNKNOWN)
        self.percent.setObjectName("percent")
        self.line = QLabel()
        self.line.setObjectName("figure")
        self.area = ElidedLabel()
        self.message = LinesLabel()
        self.map = MapCanvas(model, NoAdditions())
        self.map.setMinimumSize(1, 1)
        self.map.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.plan = new_button(self.plan_pressed.emit)
        self.notes = new_button(self.notes_pressed.emit)
        self.fault = new_button(self.fault_pressed.emit)
        self.band.touched.connect(self.fault_pressed)
        self._lay_out()
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.plan.setText(self.tr("Plan the next survey"))
        self.notes.setText(self.tr("NOTES"))
        self.fault.setText(self.tr("WHAT TO DO"))
        if self._snapshot is not None:
            self.refresh(self._snapshot)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px = look.px(GAP_PX)
        self.band.setFixedHeight(look.px(BAND_PX))
        self._band_layout.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
        self._band_layout.setSpacing(2 * gap_px)
        self._grid.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
        self._grid.setSpacing(gap_px)
        self._buttons.setSpacing(gap_px)

    def set_name(self, name: str) -> None:
        """Show what people call the survey."""
        changed, self._name = name != self._name, name
        if changed and self._snapshot is not None:
            self.refresh(self._snapshot)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._snapshot = snapshot
        job = job_of(snapshot)
        self.band.show_level(job.level)
        self.sign.show_level(job.level)
        self.title.setText(shown_text(job.title))
        self.left.setText("" if job.left is None else sentence_text(job.left))
        self.left.setVisible(job.left is not None)
        self.percent.setText(UNKNOWN if job.percent is None else f"{job.percent} %")
        self.line.setText("" if job.line is None else shown_text(job.line))
        self.line.setVisible(job.line is not None)
        parameters = snapshot.job_parameters
        area = "" if parameters is None else shown_text(area_of(parameters))
        self.area.show_text(", ".join(text for text in (self._name, area) if text))
        self.message.show_text(sentence_text(job.message))
        ended = not snapshot.running
        self.plan.setVisible(ended and snapshot.replay is None)
        self.plan.setEnabled(not snapshot.pending)
        self.notes.setVisible(snapshot.running and snapshot.replay is None)

    def draw(self, model: MapModel) -> None:
        """Draw the small map, if it is seen and something has changed."""
        state = model, model.revision, model.current
        if self.isVisible() and state != self._drawn:
            self._drawn = state
            self.map.set_model(model)

    def show_fault_button(self, shown: bool) -> None:
        """Offer the card of a fault that was closed."""
        self.fault.setVisible(shown)

    def _lay_out(self) -> None:
        band = QHBoxLayout(self.band)
        band.addWidget(self.sign)
        band.addWidget(self.title)
        band.addStretch(1)
        band.addWidget(self.left)
        self._band_layout = band
        self.percent.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignLeft)
        words = QVBoxLayout()
        words.setSpacing(0)
        words.addWidget(self.percent)
        words.addWidget(self.line)
        words.addWidget(self.area)
        words.addWidget(self.message, 1)
        buttons = QHBoxLayout()
        for button in (self.plan, self.fault, self.notes):
            buttons.addWidget(button, 1)
        self._buttons = buttons
        grid = QGridLayout(self)
        grid.addWidget(self.band, 0, 0, 1, 2)
        grid.addLayout(words, 1, 0)
        grid.addWidget(self.map, 1, 1, 2, 1)
        grid.addLayout(buttons, 2, 0)
        grid.setColumnStretch(0, 3)
        grid.setColumnStretch(1, 2)
        grid.setRowStretch(1, 1)
        self._grid = grid
