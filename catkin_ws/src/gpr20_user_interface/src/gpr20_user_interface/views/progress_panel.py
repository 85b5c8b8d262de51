"""How far the survey is."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtWidgets import QLabel, QProgressBar, QVBoxLayout, QWidget

from gpr20_user_interface.mid.events import Progress
from gpr20_user_interface.mid.progress_text import time_parts
from gpr20_user_interface.views.translation import TranslatedWidget

# The bar counts in thousandths.
FULL = 1000


class ProgressPanel(TranslatedWidget):
    """A bar with the percentage; below it traces and remaining time."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._progress: Optional[Progress] = None
        self._bar = QProgressBar()
        self._bar.setRange(0, FULL)
        self._text = QLabel()
        self._remaining = QLabel()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        for widget in (self._bar, self._text, self._remaining):
            layout.addWidget(widget)
        self.show_progress(None)

    @property
    def thousandths(self) -> int:
        """How full the bar is."""
        return self._bar.value()

    @property
    def texts(self) -> str:
        """The two lines below the bar."""
        return f"{self._text.text()}\n{self._remaining.text()}"

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.show_progress(self._progress)

    def show_progress(self, progress: Optional[Progress]) -> None:
        """Show the progress; None shows that there is none."""
        self._progress = progress
        if progress is None or progress.total_points == 0:
            self._bar.setValue(0)
            self._bar.setFormat(self.tr("no survey"))
            self._text.clear()
            self._remaining.clear()
            return
        # Rounded down: only a complete survey is shown as 100 %.
        self._bar.setValue(math.floor(progress.completion_percent * FULL / 100.0))
        self._bar.setFormat(
            self.tr("{percent} %").format(
                percent=f"{math.floor(progress.completion_percent * 10.0) / 10.0:.1f}"
            )
        )
        self._text.setText(
            self.tr("{visited} of {total} traces, {remaining} to go").format(
                visited=progress.visited_points,
                total=progress.total_points,
                remaining=progress.total_points - progress.visited_points,
            )
        )
        self._remaining.setText(self._remaining_text(progress))

    def _remaining_text(self, progress: Progress) -> str:
        parts = time_parts(progress.remaining_s)
        if progress.visited_points == 0:
            text = self.tr("{d}d:{h}h:{m}m:{s}s remaining (by the plan)")
        else:
            text = self.tr("{d}d:{h}h:{m}m:{s}s remaining (measured)")
        return text.format(d=parts.days, h=parts.hours, m=parts.minutes, s=parts.seconds)
