"""Connects RADAR with its sheet of settings, with markers and with focused images."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtWidgets import QWidget

from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.jobs.images import FocusedImages
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.pages.ground.radar_sheet import RadarSheet
from gpr20_user_interface.pages.ground.radar_view import RadarView
from gpr20_user_interface.widgets.page import Page

# Takes X, Y and depth [mm].
AskMarker = Callable[[float, float, Optional[float]], None]


class RadarBinding(Page):
    """Opens the sheet, and passes on what belongs to the survey that is shown.

    Args:
        window: The window, which the sheet covers.
        radar: The tab.
        additions: Markers and focused image of the survey.
        images: Knows why there is no focused image.
        ask_marker: Asks the operator for the text of a marker.

    Attributes:
        sheet: The settings.
    """

    def __init__(
        self,
        window: QWidget,
        radar: RadarView,
        additions: AdditionsPresenter,
        images: FocusedImages,
        ask_marker: AskMarker,
    ) -> None:
        self._radar = radar
        self._additions = additions
        self._images = images
        self.sheet = RadarSheet(window, radar.presenter)
        self.sheet.changed.connect(radar.refresh)
        self.sheet.fit_wanted.connect(radar.begin_fit)
        radar.settings.clicked.connect(lambda: self.sheet.open())
        radar.marker_wanted.connect(ask_marker)

    def refresh(self, snapshot: Snapshot) -> None:
        """Take markers of the survey that is shown, and its image with finer ones over it."""
        additions = self._additions
        self._radar.set_image(additions.laid_image, self._images.problem)
        self._radar.set_markers(additions.markers, additions.can_mark)
