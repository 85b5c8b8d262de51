"""The STATUS tab."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.health_panel import HealthPanel
from gpr20_user_interface.views.message_panel import MessagePanel
from gpr20_user_interface.views.position_panel import PositionPanel
from gpr20_user_interface.views.progress_panel import ProgressPanel


class StatusView(QWidget):
    """What the robot does, how far it is, and how its parts are."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self.message = MessagePanel()
        self.progress = ProgressPanel()
        self.positions = PositionPanel()
        self.health = HealthPanel()
        left = QVBoxLayout()
        left.addWidget(self.message, 1)
        left.addWidget(self.progress)
        left.addWidget(self.positions)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 6)
        layout.setSpacing(12)
        layout.addLayout(left, 1)
        layout.addWidget(self.health, 1)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self.message.show_state(snapshot.state)
        self.progress.show_progress(snapshot.progress)
        self.positions.show_current(snapshot.current)
        self.positions.show_target(snapshot.target)
        self.positions.show_height(snapshot.height_m)
        self.health.show_health(snapshot.health)
