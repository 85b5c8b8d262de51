"""Connects the stored traces with MAP and RADAR: which survey they show."""

from __future__ import annotations

from typing import Callable

from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_user_interface.pages.ground.band import BandPage
from gpr20_user_interface.pages.ground.map_view import MapView
from gpr20_user_interface.pages.ground.radar_view import RadarView
from gpr20_user_interface.widgets.page import Page


class TracesBinding(Page):
    """Lets MAP and RADAR follow the running survey, or a past one that was opened.

    Args:
        survey: The survey that runs.
        traces: The traces.
        map_page: MAP.
        radar_page: RADAR.
        show_radar: Brings RADAR to the front.
    """

    def __init__(
        self,
        survey: WindowPresenter,
        traces: TracePresenter,
        map_page: BandPage[MapView],
        radar_page: BandPage[RadarView],
        show_radar: Callable[[], None],
    ) -> None:
        self._survey = survey
        self._traces = traces
        self._pages = (map_page, radar_page)
        self._map = map_page.view
        self._radar = radar_page.view
        self._show_radar = show_radar
        self._shown = traces.shown
        # The operator has seen enough of a past survey.
        for page in self._pages:
            page.band.back_touched.connect(self._on_back_to_live)

    def on_event(self, event: object) -> None:
        """Take an event about traces."""
        self._traces.on_event(event)
        self._follow()

    def refresh(self, snapshot: Snapshot) -> None:
        """Follow the survey that runs."""
        self._traces.note_state(snapshot)
        self._follow()
        self._map.set_carriage(self._traces.carriage_mm)

    def draw(self) -> None:
        """Request the missing traces and draw what is new."""
        self._traces.refresh()
        self._map.refresh()
        self._radar.refresh()

    def _on_back_to_live(self) -> None:
        self._traces.show_live()
        self._follow()

    def _follow(self) -> None:
        """Show another survey if another one was opened, or the running one again."""
        for page in self._pages:
            page.band.show_band(self._traces.band)
        shown = self._traces.shown
        if shown is self._shown:
            return
        self._shown = shown
        self._map.show_models(shown.map, shown.radar)
        self._radar.show_model(shown.radar)
        if self._traces.opened_folder:
            self._show_radar()
