"""All figures of a survey, before it starts."""

from __future__ import annotations

from typing import List, Optional, Tuple

from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from gpr20_operator.plan.preview import SurveyPreview, figure_texts, spacing_warning
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button, set_look

COLUMNS, FIGURES = 2, 10
BUTTON_PX = 130


class FiguresSheet(Overlay):
    """Each figure with its title, and a warning if the spacing is too coarse for the soil."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._preview: Optional[SurveyPreview] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.close_button = new_button(self.hide)
        self.warning = QLabel()
        self.warning.setWordWrap(True)
        set_look(self.warning, "level", "doubtful")
        self._titles: List[QLabel] = []
        self._figures: List[QLabel] = []
        self._grid = QGridLayout()
        for number in range(FIGURES):
            row, column = divmod(number, COLUMNS)
            title, figure = QLabel(), QLabel()
            title.setObjectName("quiet")
            figure.setObjectName("preview")
            self._titles.append(title)
            self._figures.append(figure)
            self._grid.addWidget(title, row, 2 * column)
            self._grid.addWidget(figure, row, 2 * column + 1)
            self._grid.setRowStretch(row, 1)
        for column in range(COLUMNS):
            self._grid.setColumnStretch(2 * column + 1, 1)
        self._top = QHBoxLayout()
        self._top.addWidget(self.title, 1)
        self._top.addWidget(self.close_button)
        self._rows = QVBoxLayout(self)
        self._rows.addLayout(self._top)
        self._rows.addLayout(self._grid, 1)
        self._rows.addWidget(self.warning)
        self.retranslate()

    @property
    def figures(self) -> Tuple[str, ...]:
        """The figures as they are shown."""
        return tuple(label.text() for label in self._figures)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Figures of this survey"))
        self.close_button.setText(self.tr("CLOSE"))
        self._write()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px = look.px(GAP_PX)
        self._rows.setSpacing(gap_px)
        self._grid.setHorizontalSpacing(2 * gap_px)
        self._rows.setContentsMargins(2 * gap_px, gap_px, gap_px, gap_px)
        self.close_button.setFixedSize(look.px(BUTTON_PX), look.px(TOUCH_PX))

    def show_preview(self, preview: Optional[SurveyPreview]) -> None:
        """Show the figures; None while the parameters are wrong."""
        if preview != self._preview:
            self._preview = preview
            self._write()

    def _write(self) -> None:
        preview = self._preview
        for (title, figure), label, value in zip(
            figure_texts(preview), self._titles, self._figures
        ):
            label.setText(shown_text(title))
            value.setText(shown_text(figure))
        warning = spacing_warning(preview)
        self.warning.setText("" if warning is None else shown_text(warning))
        self.warning.setVisible(warning is not None)
