"""Connects RADAR with its sheet of settings, with focused images and with markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.mid.additions_presenter import AdditionsPresenter
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.radar_sheet import RadarSheet
from gpr20_user_interface.views.radar_view import RadarView

AskMarker = Callable[[float, float, Optional[float]], None]


@dataclass(frozen=True)
class NumberedMarker:
    """A marker of the survey, with its number in the list.

    Attributes:
        number: From 1.
        x_mm: X.
        y_mm: Y.
        depth_mm: Below the surface; None: not known.
    """

    number: int
    x_mm: float
    y_mm: float
    depth_mm: Optional[float]


class RadarBinding(Binding):
    """Opens the sheet, and passes images and markers on.

    Args:
        window: The window, which the sheet covers.
        radar: The tab.
        additions: The markers of the survey that is shown.
        ask_marker: Asks for the text of a marker at X, Y and depth [mm].

    Attributes:
        sheet: The settings.
    """

    def __init__(
        self,
        window: QWidget,
        radar: RadarView,
        additions: AdditionsPresenter,
        ask_marker: AskMarker,
    ) -> None:
        self._radar = radar
        self._additions = additions
        self._revision = -1
        self.sheet = RadarSheet(window, radar.presenter)
        self.sheet.changed.connect(radar.refresh)
        radar.settings.clicked.connect(lambda: self.sheet.open())
        radar.marker_wanted.connect(ask_marker)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show the markers of the survey, and its image with those of finer surveys over it."""
        if self._additions.revision != self._revision:
            self._revision = self._additions.revision
            self._radar.set_image(self._additions.laid_image)
            self._radar.set_markers(
                [
                    NumberedMarker(number, one.x_mm, one.y_mm, one.depth_mm)
                    for number, one in enumerate(self._additions.markers, 1)
                ]
            )
