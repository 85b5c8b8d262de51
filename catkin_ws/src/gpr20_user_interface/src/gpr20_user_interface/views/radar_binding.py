"""Connects RADAR with its sheet of settings."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.mid.focused_image import ImageFocused
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.radar_sheet import RadarSheet
from gpr20_user_interface.views.radar_view import RadarView


class RadarBinding(Binding):
    """Opens the sheet, and passes focused images on.

    Args:
        window: The window, which the sheet covers.
        radar: The tab.

    Attributes:
        sheet: The settings.
    """

    def __init__(self, window: QWidget, radar: RadarView) -> None:
        self._radar = radar
        self.sheet = RadarSheet(window, radar.presenter)
        self.sheet.changed.connect(radar.refresh)
        radar.settings.clicked.connect(lambda: self.sheet.open())

    def on_event(self, event: object) -> None:
        """Take a focused image."""
        if isinstance(event, ImageFocused):
            self._radar.set_image(event.image)
