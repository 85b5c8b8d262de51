"""Figures of the survey, before it starts."""

from __future__ import annotations

from typing import List, Optional, Tuple

from PyQt5.QtWidgets import QGridLayout, QLabel

from gpr20_user_interface.mid.parameter_form import HERTZ_PER_MEGAHERTZ
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.mid.time_words import duration
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text

UNKNOWN = "—"
COLUMNS = 4
BYTES_PER_MEGABYTE = 1.0e6
MILLIMETRES_PER_METRE = 1000.0


class PreviewPanel(TranslatedWidget):
    """Eight figures with their titles."""

    def __init__(self) -> None:
        super().__init__()
        self._preview: Optional[SurveyPreview] = None
        self._titles: List[QLabel] = []
        self._figures: List[QLabel] = []
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(0)
        grid.setHorizontalSpacing(6)
        for number in range(2 * COLUMNS):
            row, column = divmod(number, COLUMNS)
            title, figure = QLabel(), QLabel(UNKNOWN)
            title.setObjectName("quiet")
            figure.setObjectName("preview")
            self._titles.append(title)
            self._figures.append(figure)
            grid.addWidget(title, 2 * row, column)
            grid.addWidget(figure, 2 * row + 1, column)
            grid.setColumnStretch(column, 1)
        grid.setRowStretch(4, 1)
        self.retranslate()

    @property
    def figures(self) -> Tuple[str, ...]:
        """The eight figures as they are shown."""
        return tuple(label.text() for label in self._figures)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        titles = (
            self.tr("Traces"),
            self.tr("Spacing X, Y"),
            self.tr("Frequency step"),
            self.tr("Estimated time"),
            self.tr("Disk space"),
            self.tr("Resolution in air"),
            self.tr("Range in air"),
            self.tr("Stops"),
        )
        for label, title in zip(self._titles, titles):
            label.setText(title)
        self.show_preview(self._preview)

    def show_preview(self, preview: Optional[SurveyPreview]) -> None:
        """Show the figures; None while the parameters are wrong."""
        self._preview = preview
        texts = (UNKNOWN,) * len(self._figures) if preview is None else self._texts(preview)
        for label, text in zip(self._figures, texts):
            label.setText(text)

    def _texts(self, preview: SurveyPreview) -> Tuple[str, ...]:
        cost = preview.cost
        return (
            f"{preview.traces}",
            f"{preview.x_spacing_mm:.4g}, {preview.y_spacing_mm:.4g} mm",
            f"{preview.frequency_step_hz / HERTZ_PER_MEGAHERTZ:.4g} MHz",
            UNKNOWN if cost is None else shown_text(duration(cost.duration_s)),
            UNKNOWN if cost is None else f"{cost.size_bytes / BYTES_PER_MEGABYTE:.4g} MB",
            f"{preview.range_resolution_m * MILLIMETRES_PER_METRE:.4g} mm",
            f"{preview.unambiguous_range_m:.4g} m",
            f"{preview.stops}",
        )
