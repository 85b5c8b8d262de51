"""Everything that the imaging node does for the window."""

from __future__ import annotations

from typing import Callable

from gpr20_user_interface.mid.candidate_search import CandidateSearch
from gpr20_user_interface.mid.focused_images import FocusedImages
from gpr20_user_interface.mid.imaging_requests import ImagingRequests
from gpr20_user_interface.mid.survey_export import SurveyExport


class ImagingPresenter:
    """Focused images, the search for candidates and the export. Belongs to one thread.

    Args:
        requests: The imaging node.
        now_s: A clock that never goes back [s].

    Attributes:
        search: The search for candidates in a stored survey.
        export: The export to a stick.
        images: The focused image of the survey that is shown.
    """

    def __init__(self, requests: ImagingRequests, now_s: Callable[[], float]) -> None:
        self._requests = requests
        self.search = CandidateSearch(requests, now_s)
        self.export = SurveyExport(requests, now_s)
        self.images = FocusedImages(requests, now_s)

    def on_event(self, event: object) -> None:
        """Take an answer; other events are ignored."""
        self.search.on_event(event)
        self.export.on_event(event)
        self.images.on_event(event)

    def focus(self, survey_id: str, permittivity: float) -> None:
        """Ask for the focused image of another survey than the one that is shown."""
        self._requests.focus(survey_id, permittivity)

    def set_survey_runs(self, runs: bool) -> None:
        """Note whether a survey is running: nothing long begins during one."""
        self.search.set_survey_runs(runs)
        self.export.set_survey_runs(runs)

    def end(self) -> None:
        """End what the window would have waited for."""
        self.search.close()
        self.export.cancel()
