"""The widgets of RADAR and where they are."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout

from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.pages.ground.picture_plot import PicturePlot
from gpr20_user_interface.pages.ground.plots import CurvePlot, FixedPlot
from gpr20_user_interface.pages.ground.scales import ColourBar, DepthSlider

KEY_WIDTH_PX = 112
DEPTH_WIDTH_PX = 84
# The colour bar has a caption in a tab that is at least so high.
CAPTION_FROM_PX = 310


class RadarPanel(TranslatedWidget):
    """Three pictures below their titles, the depth, and a column of keys.

    Attributes:
        is_fitting: Whether the row above the line is that of the hyperbola.
    """

    def __init__(self) -> None:
        super().__init__()
        self.is_fitting = False
        self.trace_plot = CurvePlot()
        self.line_plot = PicturePlot(true_to_scale=False)
        self.slice_plot = PicturePlot(true_to_scale=True)
        self.trace_key, self.line_key, self.slice_key = (QPushButton() for _ in range(3))
        self.shallower, self.deeper = QPushButton("▲"), QPushButton("▼")
        self.depth_slider = DepthSlider()
        self.along, self.source, self.marker = (QPushButton() for _ in range(3))
        self.settings = QPushButton()
        self.use, self.drop = QPushButton(), QPushButton()
        self.fit_text = QLabel()
        self.note = QLabel()
        self.bar = ColourBar()
        # Beside the title of an enlarged picture.
        self.top_bar = ColourBar()
        self._lay_out()
        self.arrange(None, fits=False)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the tab has another size; below a band the pictures need the room."""
        super().resizeEvent(event)
        self.bar.show_caption(event.size().height() >= look_of(self).px(CAPTION_FROM_PX))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        for key in (self.along, self.source, self.marker, self.settings):
            key.setFixedWidth(look.px(KEY_WIDTH_PX))
        for widget in (self.shallower, self.deeper, self.depth_slider):
            widget.setFixedWidth(look.px(DEPTH_WIDTH_PX))
        for key in (self.trace_key, self.line_key, self.slice_key):
            key.setFixedHeight(look.px(TOUCH_PX))
        for layout in (self._titles, self._plots, self._keys, self._depths, self._columns):
            layout.setSpacing(look.px(GAP_PX))
        margin = look.px(4)
        self._whole.setContentsMargins(margin, margin, margin, margin)
        self._whole.setSpacing(look.px(2))

    def arrange(self, enlarged: Optional[FixedPlot], fits: bool) -> None:
        """Show what belongs to all three pictures, or to one of them.

        Args:
            enlarged: The picture that fills the tab; None: all three are shown.
            fits: Whether a hyperbola is fitted.
        """
        self.is_fitting = fits
        for plot, key in (
            (self.trace_plot, self.trace_key),
            (self.line_plot, self.line_key),
            (self.slice_plot, self.slice_key),
        ):
            shown = enlarged is None or plot is enlarged
            plot.setVisible(shown)
            key.setVisible(shown and not fits)
        for key in (self.along, self.source, self.marker, self.settings):
            key.setVisible(enlarged is None)
        for widget in (self.fit_text, self.use, self.drop):
            widget.setVisible(fits)
        self.bar.setVisible(enlarged is None)
        self.top_bar.setVisible(enlarged is not None)

    def _lay_out(self) -> None:
        self.note.setWordWrap(True)
        self.note.setObjectName("note")
        self.note.setTextFormat(Qt.TextFormat.PlainText)
        self.fit_text.setObjectName("title")
        ignored, fixed = QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed
        self._titles, self._plots = QHBoxLayout(), QHBoxLayout()
        for plot, key, part in (
            (self.trace_plot, self.trace_key, 4),
            (self.line_plot, self.line_key, 7),
            (self.slice_plot, self.slice_key, 7),
        ):
            key.setSizePolicy(ignored, fixed)
            self._titles.addWidget(key, part)
            self._plots.addWidget(plot, part)
        for widget in (self.fit_text, self.use, self.drop, self.top_bar):
            self._titles.addWidget(widget)
        pictures = QVBoxLayout()
        pictures.addLayout(self._titles)
        pictures.addLayout(self._plots, 1)
        self._depths, self._keys = QVBoxLayout(), QVBoxLayout()
        self._depths.addWidget(self.shallower)
        self._depths.addWidget(self.depth_slider, 1)
        self._depths.addWidget(self.deeper)
        for key in (self.along, self.source, self.marker, self.settings):
            key.setSizePolicy(fixed, QSizePolicy.Policy.Expanding)
            self._keys.addWidget(key)
        bottom = QHBoxLayout()
        bottom.addWidget(self.note, 1)
        bottom.addWidget(self.bar)
        left = QVBoxLayout()
        left.addLayout(pictures, 1)
        left.addLayout(bottom)
        self._columns = QHBoxLayout()
        self._columns.addLayout(left, 1)
        self._columns.addLayout(self._depths)
        self._columns.addLayout(self._keys)
        self._whole = QVBoxLayout(self)
        self._whole.addLayout(self._columns, 1)
        for key in (self.shallower, self.deeper):
            key.setAutoRepeat(True)
