"""Progress as a bar, for somebody at a terminal."""

from __future__ import annotations

from typing import Optional

from gpr20_user_interface.low.terminal_bar import TerminalBar
from gpr20_user_interface.mid.events import ControlState, Progress
from gpr20_user_interface.mid.progress_text import remaining_text


class BarDisplay:
    """Shows the progress as a bar and writes changes of the status above it."""

    def __init__(self, bar: TerminalBar) -> None:
        self._bar = bar
        self._state: Optional[ControlState] = None
        self._progress: Optional[Progress] = None

    def note(self, text: str) -> None:
        """Write a sentence of the client above the bar."""
        self._bar.write(text)

    def status(self, state: ControlState) -> None:
        """Write what main_control does above the bar, if that is new."""
        if state == self._state:
            return
        self._state = state
        self._bar.write(f"{state.code.name}: {state.message}")
        self._refresh()

    def progress(self, progress: Progress) -> None:
        """Move the bar."""
        self._progress = progress
        self._refresh()

    def close(self) -> None:
        """Leave the bar as it is; what follows are plain lines."""
        self._bar.close()

    def _refresh(self) -> None:
        if self._progress is None:
            return
        self._bar.show(
            self._progress.visited_points,
            self._progress.total_points,
            _before(self._state),
            remaining_text(self._progress),
        )


def _before(state: Optional[ControlState]) -> str:
    if state is None:
        return ""
    simulated = "SIMULATED " if state.simulated else ""
    return f"{simulated}{state.code.name} "
