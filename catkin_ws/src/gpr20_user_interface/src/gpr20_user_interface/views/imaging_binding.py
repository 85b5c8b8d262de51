"""Keeps the focused image fresh while MAP or RADAR is looked at."""

from __future__ import annotations

from typing import Callable

import numpy as np

from gpr20_user_interface.mid.focused_images import Wanted
from gpr20_user_interface.mid.imaging_presenter import ImagingPresenter
from gpr20_user_interface.mid.map_coverage import is_stored
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.views.binding import Binding


class ImagingBinding(Binding):
    """Asks for the image of the survey on MAP and RADAR, at most every 10 s.

    Args:
        traces: Which survey they show.
        imaging: The imaging node.
        is_seen: Returns whether one of them is looked at.
        permittivity: Returns that of the ground, as it was chosen; 0: not known.
    """

    def __init__(
        self,
        traces: TracePresenter,
        imaging: ImagingPresenter,
        is_seen: Callable[[], bool],
        permittivity: Callable[[], float],
    ) -> None:
        self._traces = traces
        self._imaging = imaging
        self._is_seen = is_seen
        self._permittivity = permittivity
        self._replay = False

    def on_event(self, event: object) -> None:
        """Take an answer of the imaging node."""
        self._imaging.on_event(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Note whether a survey is running, and whether there is a robot at all."""
        self._replay = snapshot.replay is not None
        self._imaging.set_survey_runs(snapshot.running)

    def draw(self) -> None:
        """Ask for an image, if the last one is too old."""
        if self._replay or not self._is_seen():
            return
        shown = self._traces.shown
        states = shown.map.trace_states
        stored = 0 if states is None else int(np.count_nonzero(is_stored(states)))
        self._imaging.images.keep(Wanted(shown.survey_id, stored, self._permittivity()))
