"""What every page of the window is."""

from __future__ import annotations

from gpr20_operator.robot.snapshot import Snapshot


class Page:
    """Follows events and what is known; the pages of the window override what they need."""

    def on_event(self, event: object) -> None:
        """Take an event."""

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; 5 times a second."""

    def draw(self) -> None:
        """Draw what is new; 5 times a second."""

    def show_again(self) -> None:
        """Show the same in another language, theme or size, where it was not written by `say`."""
