"""What connects a part of the window with its presenter."""

from __future__ import annotations

from gpr20_user_interface.mid.survey_model import Snapshot


class Binding:
    """Follows events and what is known; the parts of the window override what they need."""

    def on_event(self, event: object) -> None:
        """Take an event."""

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; 10 times a second."""

    def draw(self) -> None:
        """Draw what is new; 5 times a second."""
