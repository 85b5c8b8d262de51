"""What is written on RADAR."""

from __future__ import annotations

from typing import Optional, Union

from PyQt5.QtWidgets import QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.echoes import MIN_BACKGROUND_TRACES
from gpr20_operator.ground.records import Axis, Curve, Picture, Source
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground.radar_model import RadarPictures, RadarPresenter


class RadarTexts:
    """Sentences about what is shown, in the language of the application.

    Args:
        widget: Whose texts these are.
    """

    def __init__(self, widget: QWidget) -> None:
        self.tr = widget.tr

    def readout(self, presenter: RadarPresenter, shown: RadarPictures) -> str:
        """Return what is known at the crosshair."""
        if shown.place is None:
            return ""
        text = self.tr("X {x:.0f} Y {y:.0f} depth {depth:.0f} mm: {level}")
        return text.format(
            x=shown.place.x_mm,
            y=shown.place.y_mm,
            depth=shown.depth_m * 1000.0,
            level=self._level(presenter, shown),
        )

    def note(self, presenter: RadarPresenter) -> str:
        """Return what must be known about the pictures."""
        grid = presenter.model.grid
        parts = [self.tr("No echo does not mean no mine."), self._remark(presenter)]
        if grid is not None and grid.simulated:
            parts.insert(0, self.tr("SIMULATED") + ".")
        return " ".join(parts)

    def _remark(self, presenter: RadarPresenter) -> str:
        """Return the most important remark; there is no room for more."""
        model, image = presenter.model, presenter.image
        if model.given_up:
            text = self.tr("Cannot be shown: {count}.")
            return text.format(count=len(model.given_up))
        if presenter.shows_focused and image is not None:
            text = self.tr("Focused with permittivity {value:g}.")
            return text.format(value=image.found.permittivity)
        if self._lacks_background(presenter):
            text = self.tr("The background is not removed from fewer than {count} traces.")
            return text.format(count=MIN_BACKGROUND_TRACES)
        return self.tr("Hatched: not measured.")

    def line_notice(self, presenter: RadarPresenter, shown: RadarPictures) -> str:
        """Return what to write over the line."""
        if shown.line is None or not shown.line.measured or shown.line.above_noise:
            return ""
        if presenter.shows_focused:
            return self.tr("Nothing above the clutter in this line. No echo does not mean no mine.")
        return self.tr("Nothing above the noise in this line. No echo does not mean no mine.")

    def slice_notice(
        self, presenter: RadarPresenter, shown: RadarPictures, problem: Optional[Message]
    ) -> str:
        """Return what to write over the slice.

        Args:
            presenter: What is chosen.
            shown: What is shown.
            problem: Why there is no newer focused image.
        """
        if presenter.settings.source is Source.FOCUSED and not presenter.shows_focused:
            echoes = self.tr("The image is not focused yet. These are the echoes.")
            return echoes if problem is None else f"{shown_text(problem)}. {echoes}"
        if presenter.model.grid is None:
            return self.tr("No survey yet: the pictures appear when one starts.")
        if shown.slice is None and presenter.model.count:
            return self.tr("No height was measured: the depth is unknown.")
        if shown.slice is None or not shown.slice.measured or shown.slice.above_noise:
            return ""
        if presenter.shows_focused:
            return self.tr(
                "Nothing above the clutter at this depth. No echo does not mean no mine."
            )
        return self.tr("Nothing above the noise at this depth. No echo does not mean no mine.")

    def trace_title(self, presenter: RadarPresenter, shown: RadarPictures) -> str:
        """Return the title of the trace, with the level at the crosshair."""
        grid = presenter.model.grid
        title = self.tr("Trace")
        if not presenter.shows_focused and grid is not None:
            title = f"{grid.rotations_deg[presenter.settings.polarization]:g}°"
        return f"{title}\n{self._level(presenter, shown)}"

    def line_title(self, presenter: RadarPresenter, shown: RadarPictures) -> str:
        """Return the title of the line, with the place of the crosshair on it."""
        place = shown.place
        if place is None:
            return self.tr("Line")
        text = self.tr("Line at Y {y:.0f}\nX {x:.0f} mm")
        if presenter.settings.along is Axis.Y_MM:
            text = self.tr("Line at X {x:.0f}\nY {y:.0f} mm")
        return text.format(x=place.x_mm, y=place.y_mm)

    def slice_title(self, shown: RadarPictures) -> str:
        """Return the title of the slice."""
        depth_mm = shown.depth_m * 1000.0
        return self.tr("Slice\nat depth {depth:.0f} mm").format(depth=depth_mm)

    def along_key(self, along: Axis) -> str:
        """Return what the key of the line's direction says."""
        return self.tr("Line\nalong X") if along is Axis.X_MM else self.tr("Line\nalong Y")

    def source_key(self, presenter: RadarPresenter) -> str:
        """Return what the key of the source says."""
        if presenter.settings.source is Source.ECHOES:
            return self.tr("Echoes")
        return self.tr("Focused")

    def across(self, along: Axis) -> str:
        """Return the title of a line's first axis."""
        return self.tr("X mm") if along is Axis.X_MM else self.tr("Y mm")

    def second(self, shown: Union[Curve, Picture, None]) -> str:
        """Return the title of the second axis of what is shown."""
        in_time = shown is not None and shown.axis is Axis.DELAY_NS
        return self.tr("Delay ns") if in_time else self.tr("Depth mm")

    def _level(self, presenter: RadarPresenter, shown: RadarPictures) -> str:
        picture = shown.slice or shown.line
        if shown.level_db is None or picture is None:
            return "—"
        if shown.level_db <= picture.scale.threshold_db:
            return self.tr("clutter") if presenter.shows_focused else self.tr("noise")
        return self.tr("{level:.0f} dB").format(level=shown.level_db)

    @staticmethod
    def _lacks_background(presenter: RadarPresenter) -> bool:
        settings, model = presenter.settings, presenter.model
        wanted = settings.remove_background and bool(model.count)
        return wanted and model.background(settings.polarization) is None
