"""A tab that shows a survey, with the band that says which one if it is not the live one."""

from __future__ import annotations

from typing import Generic, TypeVar

from PyQt5.QtWidgets import QVBoxLayout, QWidget

from gpr20_user_interface.views.shown_band import ShownBandView

View = TypeVar("View", bound=QWidget)


class BandPage(QWidget, Generic[View]):
    """A view below a ShownBandView.

    Attributes:
        view: What the tab shows.
        band: Hidden while that is the live survey.
    """

    def __init__(self, view: View) -> None:
        super().__init__()
        self.view = view
        self.band = ShownBandView()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.band)
        layout.addWidget(view, 1)
